/** Pairs of directions, and the parameters of coats. */

import { facetCosine } from "../printed/formulas";

/** GGX widths of a surface: one, or two along and across its tangent. */
export type Widths = 1 | 2;

/** The parameters of one coat for one channel. */
export interface CoatOfChannel {
  /** GGX widths along and across the tangent; networks of one width read the first. */
  alpha: number;
  alphaV: number;
  eta: number;
  albedo: number;
  sigmaT: number;
  g: number;
}

/** What is evaluated at pairs of directions needs these. */
export class Pairs {
  readonly count: number;
  /** (count, 6) wi, then wo. */
  readonly directions: Float64Array;
  /** (count) cosine between either direction and the half vector. */
  readonly cosD: Float64Array;

  /** @param wi, wo unit vectors (count, 3). */
  constructor(
    wi: ArrayLike<number>,
    wo: ArrayLike<number>,
    readonly widths: Widths = 1,
  ) {
    this.count = wi.length / 3;
    this.directions = new Float64Array(6 * this.count);
    this.cosD = new Float64Array(this.count);
    for (let i = 0; i < this.count; i++) {
      const at = 3 * i;
      const pair = [wi[at], wi[at + 1], wi[at + 2], wo[at], wo[at + 1], wo[at + 2]] as const;
      this.directions.set(pair, 6 * i);
      this.cosD[i] = facetCosine(...pair);
    }
  }
}
