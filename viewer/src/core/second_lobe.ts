/**
 * The second lobe of a code: what shines through the topmost interface as a narrow lobe.
 *
 * Three numbers: the roots of its width alpha, and of Schlick's factors `normal` and `grazing`. See
 * Python's `nets.second_lobe`.
 */

import type { CoatOfChannel, Pairs } from "./features";
import { NO_LOBE, reflectance } from "./lobe";

/** Least root of a factor in derivatives: at zero a lobe that is absent could never appear. */
const LEAST_ROOT = 0.02;

/** Least of the three numbers, and of their logarithms, which the networks give. */
const LOWEST = [0.1, 0, 0] as const;
const LOWEST_LOGS = [0.5 * Math.log(0.01), -4.6, -4.6] as const;

/** Cosines to the facet at which Schlick's term is fitted to the exact one. */
const FITTED_COSINES = [0.1, 0.25, 0.5] as const;

/** The coat's (eta - 1) / (eta + 1) over which what `grazing` adds to `normal` vanishes. */
const GRAZING_CHANGE = 0.05;

/** The lobe [1/sr] at pair `i` of the numbers at a place of an array. */
export function secondLobeValue(
  numbers: ArrayLike<number>,
  at: number,
  pairs: Pairs,
  i: number,
): number {
  const normal = numbers[at + 1];
  const grazing = numbers[at + 2];
  if (normal === 0 && grazing === 0) {
    return 0;
  }
  const fifth = pairs.fifth[i];
  return shape(numbers[at], pairs, i) * (normal * normal * (1 - fifth) + grazing * grazing * fifth);
}

/** The lobe of a root of the width, for a reflectance of one. */
function shape(root: number, pairs: Pairs, i: number): number {
  const alpha2 = root * root * (root * root);
  const tan2 = pairs.tan2[i];
  const low = pairs.low[i];
  const high = pairs.high[i];
  const ratio = (1 + tan2) / (tan2 + alpha2);
  const rest = 1 - alpha2;
  const masking =
    (low + Math.sqrt(alpha2 + rest * (low * low))) *
    (high + Math.sqrt(alpha2 + rest * (high * high)));
  return ((alpha2 / Math.PI) * (ratio * ratio)) / masking;
}

/** `secondLobeValue`, and its derivatives by the three numbers in `slopes` at a place. */
export function secondLobeSlopes(
  numbers: ArrayLike<number>,
  at: number,
  pairs: Pairs,
  i: number,
  slopes: Float64Array,
  place: number,
): number {
  const root = numbers[at];
  const normal = numbers[at + 1];
  const grazing = numbers[at + 2];
  const fifth = pairs.fifth[i];
  const whole = shape(root, pairs, i);
  const reflected = normal * normal * (1 - fifth) + grazing * grazing * fifth;
  const alpha = root * root;
  const alpha2 = alpha * alpha;
  let byAlpha = 2 / alpha - (4 * alpha) / (pairs.tan2[i] + alpha2);
  for (const cosine of [pairs.low[i], pairs.high[i]]) {
    const cos2 = cosine * cosine;
    const length = Math.sqrt(alpha2 + (1 - alpha2) * cos2);
    byAlpha -= (alpha * (1 - cos2)) / (length * (cosine + length));
  }
  slopes[place] = 2 * root * byAlpha * whole * reflected;
  slopes[place + 1] = 2 * Math.max(normal, LEAST_ROOT) * whole * (1 - fifth);
  slopes[place + 2] = 2 * Math.max(grazing, LEAST_ROOT) * whole * fifth;
  return whole * reflected;
}

/** Clamp the numbers at a place to their bounds. */
export function bound(numbers: Float32Array, at: number): void {
  for (let k = 0; k < 3; k++) {
    numbers[at + k] = Math.min(Math.max(numbers[at + k], LOWEST[k]), 1);
  }
}

/** Make the numbers at a place of the logarithms that a network gives there. */
export function finish(numbers: Float64Array, at: number): void {
  for (let k = 0; k < 3; k++) {
    numbers[at + k] = Math.exp(Math.min(Math.max(numbers[at + k], LOWEST_LOGS[k]), 0));
  }
}

/** The six numbers of `lobe.ts` for the three at a place. */
export function asLobe(numbers: ArrayLike<number>, at: number): Float64Array {
  const lobe = Float64Array.from(NO_LOBE);
  for (let k = 0; k < 3; k++) {
    lobe[k] = numbers[at + k] * numbers[at + k];
  }
  return lobe;
}

/**
 * Put logarithms of an estimate of the second lobe that is seen through a coat into `out`.
 *
 * The bottom's sharper or brighter lobe is the one that is seen. Refraction and a rough interface
 * widen it; interface and medium let a part of its light through.
 *
 * @param code the bottom's; `rest` is where its numbers after the lobe's begin.
 */
export function underCoat(
  code: ArrayLike<number>,
  rest: number,
  coat: CoatOfChannel,
  out: Float64Array,
  place: number,
): void {
  const own = schlickOf(code);
  const other = [0, 1, 2].map((k) => code[rest + 1 + k] ** 2);
  const seen = own[1] * other[0] >= other[1] * own[0] ? own : other;
  const change = (coat.eta - 1) / (coat.eta + 1);
  const entering = 1 - change * change;
  const through = entering * entering * Math.exp(-2 * coat.sigmaT);
  const kept = Math.exp(-(change * change) / (GRAZING_CHANGE * GRAZING_CHANGE));
  const normal = seen[1] * through;
  const grazing = (seen[1] + (seen[2] - seen[1]) * kept) * through;
  const width = coat.eta * seen[0];
  const rough = (coat.eta - 1) * coat.alpha;
  out[place] = 0.25 * Math.log(width * width + 0.5 * (rough * rough));
  out[place + 1] = 0.5 * Math.log(normal + 1e-6);
  out[place + 2] = 0.5 * Math.log(grazing + 1e-6);
}

/** Width and Schlick's factors nearest to the reflectance of the lobe of a code. */
function schlickOf(lobe: ArrayLike<number>): number[] {
  const normal = reflectance(lobe, 0, 1);
  let above = 0;
  let weight = 0;
  for (const cosine of FITTED_COSINES) {
    const fifth = (1 - cosine) ** 5;
    above += fifth * (reflectance(lobe, 0, cosine) - normal * (1 - fifth));
    weight += fifth * fifth;
  }
  return [lobe[0], normal, Math.max(above / weight, 0)];
}
