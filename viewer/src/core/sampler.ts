/**
 * The sampler: from a code and a direction to the proposal, from which directions are drawn.
 *
 * The proposal is a mixture of GGX reflection lobes, mirrored above the horizon, and a cosine lobe;
 * see Python's `nets.sampler`.
 */

import {
  CHECKS,
  LOBE,
  reflectionPdf,
  reflectionPdf2,
  SAMPLER,
  sampleReflection,
  sampleReflection2,
  samplerFeatures,
  samplerFeatures2,
  type Vector,
} from "./formulas";
import type { Architecture, Layer } from "./layers";
import { lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";

/** Weights (K + 1), the last the cosine lobe's, and GGX widths (K), also those across the tangent. */
export interface Mixture {
  readonly weights: Float64Array;
  readonly alphas: Float64Array;
  readonly alphasV: Float64Array | undefined;
}

export class Sampler {
  private readonly network: Mlp;

  constructor(
    private readonly arch: Architecture,
    layers: readonly Layer[],
    activation: Activation,
  ) {
    this.network = new Mlp(layers, activation);
  }

  /** The proposals of a code for directions wi, of which each is computed when it is asked for. */
  proposals(code: Float32Array): (wi: Vector) => Mixture {
    const { rest, lobes, lobe, widths } = this.arch;
    const ofLobe = LOBE.LOBE_FEATURES[widths];
    const ofCode = ofLobe + rest;
    const inputs = new Float64Array(ofCode + 2 * widths);
    lobeFeatures(code, inputs, 0, widths);
    inputs.set(code.subarray(lobe), ofLobe);
    const count = 1 + lobes;
    return ({ x, y, z }) => {
      (widths === 1 ? samplerFeatures : samplerFeatures2)(x, y, z, inputs, ofCode);
      const output = this.network.evaluate(inputs, 1);
      const ofWidth = (own: number, start: number) => {
        // Between ln 1 and ln MIN_ALPHA by a logistic function
        const logs = output
          .subarray(start, start + lobes)
          .map((x) => 0.5 - 0.5 * Math.tanh(0.5 * x));
        const alphas = [own, ...logs.map((share) => Math.exp(Math.log(CHECKS.MIN_ALPHA) * share))];
        return Float64Array.from(alphas, (alpha) => Math.min(Math.max(alpha, CHECKS.MIN_ALPHA), 1));
      };
      const alphas = ofWidth(code[0], count + 1);
      const alphasV = widths === 2 ? ofWidth(code[6], count + 1 + lobes) : undefined;
      return { weights: shares(output.subarray(0, count + 1)), alphas, alphasV };
    };
  }
}

function shares(logits: Float64Array): Float64Array {
  const peak = Math.max(...logits);
  const weights = logits.map((logit) => Math.exp(logit - peak));
  const factor = (1 - SAMPLER.MIN_COSINE_SHARE) / weights.reduce((a, b) => a + b, 0);
  return weights.map((weight, k) => {
    const least = k + 1 === weights.length ? SAMPLER.MIN_COSINE_SHARE : 0;
    return weight * factor + least;
  });
}

/** The density [1/sr] of `sampleMixture` at wo; 0 below the horizon. */
export function mixtureDensity(
  { weights, alphas, alphasV }: Mixture,
  wi: Vector,
  wo: Vector,
): number {
  if (!(wi.z > 0 && wo.z > 0)) return 0;
  let density = (weights[alphas.length] * wo.z) / Math.PI;
  for (let k = 0; k < alphas.length; k++) {
    const lobe = alphasV
      ? reflectionPdf2(alphas[k], alphasV[k], wi.x, wi.y, wi.z, wo.x, wo.y, wo.z)
      : reflectionPdf(alphas[k], wi.x, wi.y, wi.z, wo.x, wo.y, wo.z);
    density += weights[k] * lobe;
  }
  return density;
}

/** A direction drawn by three uniform numbers in [0, 1): the lobe by the first. */
export function sampleMixture(
  { weights, alphas, alphasV }: Mixture,
  wi: Vector,
  u0: number,
  u1: number,
  u2: number,
): Vector {
  let edge = weights[0];
  let chosen = 0;
  for (let k = 1; k < alphas.length; k++) {
    if (u0 >= edge) chosen = k;
    edge += weights[k];
  }
  if (u0 >= edge) {
    const [radius, phi] = [Math.sqrt(u1), 2 * Math.PI * u2];
    return { x: radius * Math.cos(phi), y: radius * Math.sin(phi), z: Math.sqrt(1 - u1) };
  }
  return alphasV
    ? sampleReflection2(alphas[chosen], alphasV[chosen], wi.x, wi.y, wi.z, u1, u2)
    : sampleReflection(alphas[chosen], wi.x, wi.y, wi.z, u1, u2);
}
