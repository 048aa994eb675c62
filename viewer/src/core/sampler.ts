/**
 * The sampler: from a code and a cosine to the proposal, from which directions are drawn.
 *
 * The proposal is a mixture of GGX reflection lobes, mirrored above the horizon, and a cosine lobe;
 * see Python's `nets.sampler`.
 */

import { MIN_COSINE } from "./features";
import { LOBE_FEATURES, lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";
import { LOBE_NUMBERS, type Weights } from "./weights";

/** Least weight of the cosine lobe. */
const MIN_COSINE_SHARE = 0.02;

const MIN_ALPHA = 0.01;
const LOG_MIN_ALPHA = -4.605170185988092;

/** Weights (K + 1), the last the cosine lobe's, and GGX widths (K). */
export interface Mixture {
  readonly weights: Float64Array;
  readonly alphas: Float64Array;
}

export class Sampler {
  private readonly network: Mlp;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.sampler, activation);
  }

  /** The proposals of a code for cosines of wi, of which each is computed when it is asked for. */
  proposals(code: Float32Array): (cosine: number) => Mixture {
    const { rest, lobes } = this.weights.arch;
    const ofCode = LOBE_FEATURES + rest;
    const inputs = new Float64Array(ofCode + 2);
    lobeFeatures(code, 0, inputs, 0);
    inputs.set(code.subarray(LOBE_NUMBERS), LOBE_FEATURES);
    const count = 1 + lobes;
    return (cosine) => {
      const raised = Math.max(cosine, MIN_COSINE);
      inputs[ofCode] = (raised - 0.5) * 3;
      inputs[ofCode + 1] = Math.log(raised) + 1;
      const output = this.network.evaluate(inputs, 1);
      const alphas = new Float64Array(count);
      alphas[0] = clampedAlpha(code[0]);
      for (let k = 0; k < lobes; k++) {
        const fraction = 0.5 - 0.5 * Math.tanh(0.5 * output[count + 1 + k]);
        alphas[1 + k] = clampedAlpha(Math.exp(LOG_MIN_ALPHA * fraction));
      }
      return { weights: shares(output, count + 1), alphas };
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

/** The density [1/sr] of `sampleMixture`, given the pair; 0 below the horizon. */
export function mixtureDensity(
  { weights, alphas }: Mixture,
  cosI: number,
  cosO: number,
  across: number,
): number {
  if (!(cosI > 0 && cosO > 0)) {
    return 0;
  }
  let density = (weights[alphas.length] * cosO) / Math.PI;
  for (let k = 0; k < alphas.length; k++) {
    density += weights[k] * reflectionDensity(alphas[k], cosI, cosO, across);
  }
  return density;
}

/** Density [1/sr] of `sampleReflection`, its mirrored part included; across: |wi + wo|_xy^2. */
function reflectionDensity(alpha: number, cosI: number, cosO: number, across: number): number {
  const alpha2 = alpha * alpha;
  const down = cosI - cosO;
  const total =
    scaledGgx(alpha2, across, cosI + cosO) + (down > 0 ? scaledGgx(alpha2, across, down) : 0);
  const below = cosI + Math.sqrt(alpha2 + (1 - alpha2) * (cosI * cosI));
  return (total * (alpha2 / (2 * Math.PI))) / below;
}

function scaledGgx(alpha2: number, across: number, z: number): number {
  const ratio = (across + z * z) / Math.max(across + alpha2 * (z * z), 1e-18);
  return ratio * ratio;
}

/**
 * Put a direction drawn by three uniform numbers in [0, 1) into `wo`, for wi = (x, 0, z).
 *
 * The first selects the lobe, the other two the direction.
 */
export function sampleMixture(
  { weights, alphas }: Mixture,
  wi: readonly [number, number],
  u0: number,
  u1: number,
  u2: number,
  wo: Float64Array,
): void {
  let edge = weights[0];
  let alpha = alphas[0];
  for (let k = 1; k < alphas.length; k++) {
    if (u0 >= edge) {
      alpha = alphas[k];
    }
    edge += weights[k];
  }
  if (u0 < edge) {
    sampleReflection(alpha, wi, u1, u2, wo);
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
  alpha: number,
  [wx, wz]: readonly [number, number],
  u1: number,
  u2: number,
  wo: Float64Array,
): void {
  const length = Math.hypot(alpha * wx, wz);
  const x = (alpha * wx) / length;
  const z = wz / length;
  const phi = 2 * Math.PI * u1;
  const capZ = (1 - u2) * (1 + z) - z;
  const capR = Math.sqrt(Math.max(1 - capZ * capZ, 0));
  const hx = alpha * (capR * Math.cos(phi) + x);
  const hy = alpha * (capR * Math.sin(phi));
  const hz = capZ + z;
  const scale = (2 * (wx * hx + wz * hz)) / Math.max(hx * hx + hy * hy + hz * hz, 1e-18);
  wo[0] = scale * hx - wx;
  wo[1] = scale * hy;
  wo[2] = Math.abs(scale * hz - wz);
}
