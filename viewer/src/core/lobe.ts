/**
 * The analytic lobe of a code: one GGX lobe with the separable Smith term; see Python's `nets.lobe`.
 *
 * Its six numbers: the width alpha, factors of Schlick's term at normal and at grazing incidence, a
 * factor of the exact Fresnel term, and the complex index eta - i k of the latter. Lobes of
 * anisotropic networks have a seventh, the width across the tangent; the first is that along it.
 */

import type { Pairs, Widths } from "./features";

/** The numbers of a surface without a lobe, for lobes of one width. */
export const NO_LOBE: readonly number[] = [1, 0, 0, 0, 1.5, 0];

/** Numbers of a lobe by its widths. */
export const LOBE_NUMBERS = { 1: 6, 2: 7 } as const;

/** The numbers of a surface without a lobe. */
export function noLobe(widths: Widths): readonly number[] {
  return widths === 1 ? NO_LOBE : [...NO_LOBE, 1];
}

/** Number of features of a lobe; their means and scales; cosines of the reflectances in them. */
export const LOBE_FEATURES = { 1: 6, 2: 8 } as const;
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
  if (pairs.widths === 2) {
    return anisotropicShape(lobe, at, pairs, i) * reflectance(lobe, at, pairs.cosD[i]);
  }
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

/** The lobe of two widths for a reflectance of one (Heitz 2014, equations 80 and 85). */
function anisotropicShape(lobe: ArrayLike<number>, at: number, pairs: Pairs, i: number): number {
  const [u, v] = [lobe[at], lobe[at + 6]];
  const product = u * v;
  const cosI = pairs.cosI[i];
  const cosO = pairs.cosO[i];
  const { flat } = pairs;
  const [ix, iy, ox, oy] = [flat[4 * i], flat[4 * i + 1], flat[4 * i + 2], flat[4 * i + 3]];
  const [x, y, z] = [ix + ox, iy + oy, cosI + cosO];
  const squeezed = x * x * (v / u) + y * y * (u / v);
  const ratio = (x * x + y * y + z * z) / (squeezed + product * (z * z) + 1e-18);
  const masked = (wx: number, wy: number, cos: number) =>
    cos + Math.sqrt(u * wx * (u * wx) + v * wy * (v * wy) + cos * cos);
  return ((product / Math.PI) * (ratio * ratio)) / (masked(ix, iy, cosI) * masked(ox, oy, cosO));
}

/** Put the features of a lobe into `out` at a place; its numbers begin at `at`. */
export function lobeFeatures(
  lobe: ArrayLike<number>,
  at: number,
  out: Float64Array,
  place: number,
  widths: Widths,
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
  if (widths === 2) {
    columns.push(seen * Math.log(lobe[at + 6]), seen * lobe[at + 6]);
  }
  columns.forEach((column, k) => {
    // Those of the second width have the statistics of the first.
    const own = k % FEATURE_MEANS.length;
    out[place + k] = (column - FEATURE_MEANS[own]) / FEATURE_SCALES[own];
  });
}
