/** The analytic lobe of a code, whose numbers `LOBE.NUMBERS` names; see Python's `nets.lobe`. */

import { fresnel, LOBE, lobeShape, schlick, transmittance, type Vector } from "../printed/formulas";
import type { Pairs, Widths } from "./f_table";

/** The numbers of a surface without a lobe. */
export function noLobe(widths: Widths): readonly number[] {
  return widths === 1 ? LOBE.NO_LOBE : [...LOBE.NO_LOBE, 1];
}

/** Reflectance at a cosine to the facet of the lobe that begins a code. */
export function reflectance(code: Float32Array, cosine: number): number {
  const value = schlick(code[1], code[2], cosine);
  return code[3] === 0 ? value : value + code[3] * fresnel(cosine, code[4], code[5]);
}

/** The GGX widths, along and across the tangent, of a code's lobe. */
export function widthsOfLobe(code: Float32Array, widths: Widths): readonly [number, number] {
  return [code[0], code[widths === 1 ? 0 : 6]];
}

/** The lobe [1/sr] of a code at pair `i`. */
export function lobeValue(code: Float32Array, pairs: Pairs, i: number): number {
  if (code[1] === 0 && code[2] === 0 && code[3] === 0) return 0;
  const [w, k] = [pairs.directions, 6 * i];
  const [u, v] = widthsOfLobe(code, pairs.widths);
  const shape = lobeShape(u, v, w[k], w[k + 1], w[k + 2], w[k + 3], w[k + 4], w[k + 5]);
  return shape * reflectance(code, pairs.cosD[i]);
}

/** Whether T of a code's lobe is other than one; see Python's `nets.transmittance`. */
export function hasEdges(code: Float32Array): boolean {
  return code[3] > 0 && code[4] < 1 && code[5] === 0;
}

/** T of a code's lobe for a direction. */
export function passed(code: Float32Array, widths: Widths, { x, y, z }: Vector): number {
  if (!hasEdges(code)) return 1;
  return transmittance(...widthsOfLobe(code, widths), code[3], code[4], code[5], x, y, z);
}

/** T of a code's lobe at pair `i` in both ways, a factor of the code's rest. */
export function passedBothWays(
  code: Float32Array,
  { directions: w, widths }: Pairs,
  i: number,
): number {
  if (!hasEdges(code)) return 1;
  const one = (k: number) => passed(code, widths, { x: w[k], y: w[k + 1], z: w[k + 2] });
  return one(6 * i) * one(6 * i + 3);
}
