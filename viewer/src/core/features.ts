/** Pairs of directions, and the parameters of coats. */

import { facetCosine } from "./formulas";

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
  /** (count, 6) wi, then wo. */
  readonly directions: Float64Array;
  /** (count) cosine between either direction and the half vector. */
  readonly cosD: Float64Array;

  constructor(
    readonly count: number,
    readonly widths: Widths = 1,
  ) {
    this.directions = new Float64Array(6 * count);
    this.cosD = new Float64Array(count);
  }

  /** The pairs of directions (N, 3). */
  static of(wi: ArrayLike<number>, wo: ArrayLike<number>, widths: Widths = 1): Pairs {
    const pairs = new Pairs(wi.length / 3, widths);
    for (let i = 0; i < pairs.count; i++) {
      const at = 3 * i;
      pairs.set(i, wi[at], wi[at + 1], wi[at + 2], wo[at], wo[at + 1], wo[at + 2]);
    }
    return pairs;
  }

  /** Set pair `i` to unit vectors. */
  set(i: number, ix: number, iy: number, iz: number, ox: number, oy: number, oz: number): void {
    const { directions } = this;
    const at = 6 * i;
    directions[at] = ix;
    directions[at + 1] = iy;
    directions[at + 2] = iz;
    directions[at + 3] = ox;
    directions[at + 4] = oy;
    directions[at + 5] = oz;
    this.cosD[i] = facetCosine(ix, iy, iz, ox, oy, oz);
  }
}
