/** What the core needs of a representation of f without its topmost lobe. */

import type { Pairs, Widths } from "./features";

/** What is known of pairs of directions whatever the code; see `Rests.at`. */
export interface AtPairs {
  readonly pairs: Pairs;
  /** Number of the pairs, the first of all. */
  readonly count: number;
  readonly values: Float64Array;
}

/** Codes are arrays of all their numbers, which begin with those of the lobe. */
export interface Rests {
  readonly widths: Widths;
  /** Pairs at which f must be known for a code. */
  readonly probes: Pairs;
  /** What `values` needs of the first `count` pairs. */
  at(pairs: Pairs, count?: number): AtPairs;
  /** f (count) [1/sr] of a code without its lobe. */
  values(code: Float32Array, at: AtPairs): Float64Array;
  /** The code of a lobe and of f [1/sr], of which the lobe is a part, at the probe pairs. */
  encode(lobe: Float32Array, f: Float64Array): Float32Array;
  /** The code of a lobe alone. */
  without(lobe: Float32Array): Float32Array;
}

/** Multiply the rest of a code, whose gain is at a place, by a factor > 0. */
export function scaleRest(code: Float32Array, gain: number, factor: number): void {
  code[gain] += Math.log(factor);
}

/** What a lobe leaves of f, at least zero. */
export function difference(f: Float64Array, top: Float64Array): Float64Array {
  return f.map((value, i) => Math.max(value - top[i], 0));
}
