/** The analytic lobe of a code, whose numbers `LOBE.NUMBERS` names; see Python's `nets.lobe`. */

import type { Pairs, Widths } from "./features";
import {
  fresnel,
  LOBE,
  lobeFeatures as lobeColumns,
  lobeFeatures2 as lobeColumns2,
  lobeShape,
  schlick,
} from "./formulas";

/** The numbers of a surface without a lobe. */
export function noLobe(widths: Widths): readonly number[] {
  return widths === 1 ? LOBE.NO_LOBE : [...LOBE.NO_LOBE, 1];
}

/** Whether the lobe whose numbers begin at a place of an array reflects nothing. */
export function isDark(lobe: ArrayLike<number>, at: number): boolean {
  return lobe[at + 1] === 0 && lobe[at + 2] === 0 && lobe[at + 3] === 0;
}

/** Reflectance at a cosine to the facet of the lobe whose numbers begin at a place of an array. */
export function reflectance(lobe: ArrayLike<number>, at: number, cosine: number): number {
  const value = schlick(lobe[at + 1], lobe[at + 2], cosine);
  const exact = lobe[at + 3];
  return exact === 0 ? value : value + exact * fresnel(cosine, lobe[at + 4], lobe[at + 5]);
}

/** The lobe [1/sr] at pair `i`; its numbers begin at a place of an array. */
export function lobeValue(lobe: ArrayLike<number>, at: number, pairs: Pairs, i: number): number {
  if (isDark(lobe, at)) return 0;
  const [w, k, u] = [pairs.directions, 6 * i, lobe[at]];
  const v = pairs.widths === 1 ? u : lobe[at + 6];
  const shape = lobeShape(u, v, w[k], w[k + 1], w[k + 2], w[k + 3], w[k + 4], w[k + 5]);
  return shape * reflectance(lobe, at, pairs.cosD[i]);
}

/** The lobe (count) [1/sr] at all pairs. */
export function lobeValues(lobe: ArrayLike<number>, pairs: Pairs): Float64Array {
  return Float64Array.from(pairs.cosD, (_, i) => lobeValue(lobe, 0, pairs, i));
}

/** Put the features of a lobe into `out` at a place. */
export function lobeFeatures(
  lobe: ArrayLike<number>,
  out: Float64Array,
  place: number,
  widths: Widths,
): void {
  const [a, b, c] = LOBE.COSINES.map((cosine) => reflectance(lobe, 0, cosine));
  if (widths === 1) lobeColumns(lobe[0], a, b, c, out, place);
  else lobeColumns2(lobe[0], lobe[6], a, b, c, out, place);
}
