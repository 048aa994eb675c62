/**
 * The analytic lobe of a code: one GGX lobe with the separable Smith term; see Python's `nets.lobe`.
 *
 * Its six numbers: the width alpha, factors of Schlick's term at normal and at grazing incidence, a
 * factor of the exact Fresnel term, and the complex index eta - i k of the latter.
 */

import type { Pairs } from "./features";

/** The numbers of a surface without a lobe. */
export const NO_LOBE: readonly number[] = [1, 0, 0, 0, 1.5, 0];

/** Number of features of a lobe; their means and scales; cosines of the reflectances in them. */
export const LOBE_FEATURES = 6;
const FEATURE_MEANS = [-0.9, 0.22, 0.45, 0.47, 0.55, -1.5] as const;
const FEATURE_SCALES = [1.1, 0.3, 0.4, 0.4, 0.35, 1.5] as const;
const COSINES = [1.0, 0.5, 0.2] as const;

/** Mean reflectance at which half of a lobe's width counts in its features. */
const VISIBLE = 0.01;

/** Reflectance at a cosine to the facet of the lobe whose numbers begin at a place of an array. */
export function reflectance(lobe: ArrayLike<number>, at: number, cosine: number): number {
  const fifth = fifthPower(1 - cosine);
  const schlick = lobe[at + 1] * (1 - fifth) + lobe[at + 2] * fifth;
  const exact = lobe[at + 3];
  return exact === 0 ? schlick : schlick + exact * fresnel(cosine, lobe[at + 4], lobe[at + 5]);
}

/** The fifth power of a number, clamped to [0, 1]. */
function fifthPower(x: number): number {
  const clamped = Math.min(Math.max(x, 0), 1);
  const squared = clamped * clamped;
  return squared * squared * clamped;
}

/**
 * Unpolarised reflectance of a smooth surface of index eta - i k (PBRT v3, 8.2.1).
 *
 * k = 0 is a dielectric; eta < 1 reflects totally beyond the critical angle.
 */
export function fresnel(cosine: number, eta: number, k: number): number {
  const cos2 = cosine * cosine;
  const sin2 = 1 - cos2;
  const difference = (eta - 1) * (eta + 1) - k * k + cos2;
  const size = Math.sqrt(difference * difference + 4 * (eta * eta) * (k * k));
  const a = Math.sqrt(0.5 * Math.max(size + difference, 0));
  const first = size + cos2;
  const second = 2 * a * cosine;
  const perpendicular = (first - second) / (first + second);
  const third = cos2 * size + sin2 * sin2;
  const fourth = second * sin2;
  const ratio = (third - fourth + 1e-12) / (third + fourth + 1e-12);
  return 0.5 * perpendicular * (1 + ratio);
}

/** The lobe [1/sr] at pair `i`; its numbers begin at a place of an array. */
export function lobeValue(lobe: ArrayLike<number>, at: number, pairs: Pairs, i: number): number {
  if (lobe[at + 1] === 0 && lobe[at + 2] === 0 && lobe[at + 3] === 0) {
    return 0;
  }
  const cosI = pairs.cosI[i];
  const cosO = pairs.cosO[i];
  const alpha2 = lobe[at] * lobe[at];
  const across = pairs.across[i];
  const z = cosI + cosO;
  const z2 = z * z;
  const ratio = (across + z2) / (across + alpha2 * z2 + 1e-18);
  const rest = 1 - alpha2;
  const masking =
    (cosI + Math.sqrt(alpha2 + rest * (cosI * cosI))) *
    (cosO + Math.sqrt(alpha2 + rest * (cosO * cosO)));
  const shape = ((alpha2 / Math.PI) * (ratio * ratio)) / masking;
  return shape * reflectance(lobe, at, pairs.cosD[i]);
}

/** Put the six features of a lobe into `out` at a place; its numbers begin at `at`. */
export function lobeFeatures(
  lobe: ArrayLike<number>,
  at: number,
  out: Float64Array,
  place: number,
): void {
  const [a, b, c] = COSINES;
  const first = reflectance(lobe, at, a);
  const second = reflectance(lobe, at, b);
  const third = reflectance(lobe, at, c);
  const mean = (first + second + third) / 3;
  const seen = mean / (mean + VISIBLE);
  const alpha = lobe[at];
  const columns = [
    seen * Math.log(alpha),
    seen * alpha,
    first,
    second,
    third,
    Math.log(mean + VISIBLE),
  ];
  for (let k = 0; k < LOBE_FEATURES; k++) {
    out[place + k] = (columns[k] - FEATURE_MEANS[k]) / FEATURE_SCALES[k];
  }
}
