/**
 * The sampler: from a code and a cosine to the proposal, from which directions are drawn.
 *
 * The proposal is a mixture of GGX reflection lobes, mirrored above the horizon, and a cosine lobe;
 * see Python's `nets.sampler`.
 */

import { MIN_COSINE } from "./features";
import { LOBE_FEATURES, lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";
import type { Weights } from "./weights";

/** Least weight of the cosine lobe. */
const MIN_COSINE_SHARE = 0.02;

const MIN_ALPHA = 0.01;
const LOG_MIN_ALPHA = -4.605170185988092;

/** Weights (K + 1), the last the cosine lobe's, and GGX widths (K) along and across the tangent. */
export interface Mixture {
  readonly weights: Float64Array;
  readonly alphas: Float64Array;
  readonly alphasV: Float64Array;
}

/** A direction. */
export type Direction = readonly [x: number, y: number, z: number];

export class Sampler {
  private readonly network: Mlp;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.sampler, activation);
  }

  /** The proposals of a code for directions wi, of which each is computed when it is asked for. */
  proposals(code: Float32Array): (wi: Direction) => Mixture {
    const { rest, lobes, lobe, widths } = this.weights.arch;
    const ofLobe = LOBE_FEATURES[widths];
    const ofCode = ofLobe + rest;
    const inputs = new Float64Array(ofCode + 2 * widths);
    lobeFeatures(code, 0, inputs, 0, widths);
    inputs.set(code.subarray(lobe), ofLobe);
    const count = 1 + lobes;
    return ([x, y, z]) => {
      const raised = Math.max(z, MIN_COSINE);
      inputs[ofCode] = (raised - 0.5) * 3;
      inputs[ofCode + 1] = Math.log(raised) + 1;
      if (widths === 2) {
        inputs[ofCode + 2] = (x * x - 0.33) * 3;
        inputs[ofCode + 3] = (y * y - 0.33) * 3;
      }
      const output = this.network.evaluate(inputs, 1);
      const ofWidth = (own: number, start: number) => {
        const alphas = new Float64Array(count);
        alphas[0] = clampedAlpha(own);
        for (let k = 0; k < lobes; k++) {
          const fraction = 0.5 - 0.5 * Math.tanh(0.5 * output[start + k]);
          alphas[1 + k] = clampedAlpha(Math.exp(LOG_MIN_ALPHA * fraction));
        }
        return alphas;
      };
      const alphas = ofWidth(code[0], count + 1);
      const alphasV = widths === 2 ? ofWidth(code[6], count + 1 + lobes) : alphas;
      return { weights: shares(output, count + 1), alphas, alphasV };
    };
  }
}

function clampedAlpha(alpha: number): number {
  return Math.min(Math.max(alpha, MIN_ALPHA), 1);
}

function shares(logits: Float64Array, count: number): Float64Array {
  let peak = Number.NEGATIVE_INFINITY;
  for (let k = 0; k < count; k++) {
    peak = Math.max(peak, logits[k]);
  }
  const weights = new Float64Array(count);
  let sum = 0;
  for (let k = 0; k < count; k++) {
    weights[k] = Math.exp(logits[k] - peak);
    sum += weights[k];
  }
  for (let k = 0; k < count; k++) {
    weights[k] *= (1 - MIN_COSINE_SHARE) / sum;
  }
  weights[count - 1] += MIN_COSINE_SHARE;
  return weights;
}

/** The density [1/sr] of `sampleMixture` at wo; 0 below the horizon. */
export function mixtureDensity(
  { weights, alphas, alphasV }: Mixture,
  wi: Direction,
  wo: Direction,
): number {
  if (!(wi[2] > 0 && wo[2] > 0)) {
    return 0;
  }
  let density = (weights[alphas.length] * wo[2]) / Math.PI;
  for (let k = 0; k < alphas.length; k++) {
    density += weights[k] * reflectionDensity(alphas[k], alphasV[k], wi, wo);
  }
  return density;
}

/** Density [1/sr] of `sampleReflection`, its mirrored part included. */
function reflectionDensity(u: number, v: number, wi: Direction, wo: Direction): number {
  const [x, y] = [wi[0] + wo[0], wi[1] + wo[1]];
  const [cosI, cosO] = [wi[2], wo[2]];
  const across = x * x + y * y;
  const squeezed = u === v ? across : x * x * (v / u) + y * y * (u / v);
  const alpha2 = u * v;
  const down = cosI - cosO;
  const total =
    scaledGgx(alpha2, across, squeezed, cosI + cosO) +
    (down > 0 ? scaledGgx(alpha2, across, squeezed, down) : 0);
  const [wide, deep] = [u * wi[0], v * wi[1]];
  const sine2 = u === v ? alpha2 * (1 - cosI * cosI) : wide * wide + deep * deep;
  const below = cosI + Math.sqrt(sine2 + cosI * cosI);
  return (total * (alpha2 / (2 * Math.PI))) / below;
}

function scaledGgx(alpha2: number, across: number, squeezed: number, z: number): number {
  const ratio = (across + z * z) / Math.max(squeezed + alpha2 * (z * z), 1e-18);
  return ratio * ratio;
}

/**
 * Put a direction drawn by three uniform numbers in [0, 1) into `wo`.
 *
 * The first selects the lobe, the other two the direction.
 */
export function sampleMixture(
  { weights, alphas, alphasV }: Mixture,
  wi: Direction,
  u0: number,
  u1: number,
  u2: number,
  wo: Float64Array,
): void {
  let edge = weights[0];
  let chosen = 0;
  for (let k = 1; k < alphas.length; k++) {
    if (u0 >= edge) {
      chosen = k;
    }
    edge += weights[k];
  }
  if (u0 < edge) {
    sampleReflection(alphas[chosen], alphasV[chosen], wi, u1, u2, wo);
    return;
  }
  const radius = Math.sqrt(u1);
  const phi = 2 * Math.PI * u2;
  wo[0] = radius * Math.cos(phi);
  wo[1] = radius * Math.sin(phi);
  wo[2] = Math.sqrt(1 - u1);
}

/** Reflect wi about a visible normal and mirror it up (Dupuy and Benyoub 2023, listing 1). */
function sampleReflection(
  u: number,
  v: number,
  [wx, wy, wz]: Direction,
  u1: number,
  u2: number,
  wo: Float64Array,
): void {
  const length = Math.hypot(u * wx, v * wy, wz);
  const x = (u * wx) / length;
  const y = (v * wy) / length;
  const z = wz / length;
  const phi = 2 * Math.PI * u1;
  const capZ = (1 - u2) * (1 + z) - z;
  const capR = Math.sqrt(Math.max(1 - capZ * capZ, 0));
  const hx = u * (capR * Math.cos(phi) + x);
  const hy = v * (capR * Math.sin(phi) + y);
  const hz = capZ + z;
  const product = 2 * (wx * hx + wy * hy + wz * hz);
  const scale = product / Math.max(hx * hx + hy * hy + hz * hz, 1e-18);
  wo[0] = scale * hx - wx;
  wo[1] = scale * hy - wy;
  wo[2] = Math.abs(scale * hz - wz);
}
