/**
 * The linear basis: f of a code without its lobe, by functions over directions.
 *
 *     ln f(wi, wo) = b(x) + sum_k c_k U_k(x)
 *
 * x are the coordinates of tables, and the numbers c_k follow those of the lobe in a code. The first
 * function is one; see Python's `nets.basis`. For two GGX widths, the coordinates are stretched, and
 * the last functions are multiplied by factors of the azimuth. The logarithm of the stretch is the
 * last number of the code; see `nets.stretched_basis`.
 */

import { fittedCode } from "./code_fit";
import { Cell, clampedLog, type FTable, NODES, tableValues } from "./f_table";
import type { Pairs, Widths } from "./features";
import { BASIS, TABLE } from "./formulas";
import { lobeValues } from "./lobe";
import { probePairs } from "./probe_pairs";

/** The parameters of a basis of K functions. */
export interface BasisWeights {
  readonly widths: Widths;
  /** (nodes, 1 + K): b, then the functions. */
  readonly rows: Float32Array;
  /** The first number of a row that each of `Cell.factors` multiplies, and 1 + K. */
  readonly bounds: readonly number[];
  /** (N) share of each probe pair in integrals over pairs. */
  readonly measure: Float64Array;
  /** (K, K) inverse covariance of the codes of the training materials. */
  readonly prior: Float64Array;
}

/** What is known of pairs of directions whatever the code; see `Basis.at`. */
export interface AtPairs {
  readonly pairs: Pairs;
  /** Number of the pairs, the first of all. */
  readonly count: number;
  /** Of one width: the functions (count, 1 + K). */
  readonly values: Float64Array;
}

export class Basis {
  readonly widths: Widths;
  /** Pairs at which f must be known for a code. */
  readonly probes: Pairs;
  /** Numbers of a row, 1 + K. */
  private readonly width: number;
  private atProbes: Float64Array | undefined;

  constructor(
    private readonly weights: BasisWeights,
    private readonly lobe: number,
  ) {
    this.widths = weights.widths;
    this.width = weights.bounds[weights.bounds.length - 1];
    this.probes = probePairs(weights.measure.length, weights.widths);
  }

  /** What `values` needs of pairs. */
  at(pairs: Pairs): AtPairs {
    const count = pairs.capacity;
    const values = this.widths === 1 ? this.functions(pairs, count) : new Float64Array();
    return { count, values, pairs };
  }

  /** f (count) [1/sr] of a code without its lobe. */
  values(code: Float32Array, { count, values, pairs }: AtPairs): Float64Array {
    const { width, lobe } = this;
    const result = new Float64Array(count);
    if (this.widths === 2) {
      tableValues(this.table([code]), pairs, count, result);
      return result;
    }
    for (let i = 0, at = 0; i < count; i++, at += width) {
      let log = values[at];
      for (let k = 1; k < width; k++) log += values[at + k] * code[lobe + k - 1];
      result[i] = Math.exp(clampedLog(log));
    }
    return result;
  }

  /**
   * The code of a lobe and of f [1/sr], of which the lobe is a part, at the probe pairs. Of two widths,
   * the rest must be the same for turned directions, as of diffuse surfaces: it has no stretch.
   */
  encode(lobe: Float32Array, f: Float64Array): Float32Array {
    const { measure, prior } = this.weights;
    const rest = difference(f, lobeValues(lobe, this.probes));
    this.atProbes ??= this.functions(this.probes, measure.length);
    const numbers = fittedCode(this.atProbes, measure, prior, rest);
    return Float32Array.of(...lobe, ...numbers, ...(this.widths === 2 ? [0] : []));
  }

  /** The code of a lobe alone. */
  without(lobe: Float32Array): Float32Array {
    const code = new Float32Array(lobe.length + this.width - 1 + Number(this.widths === 2));
    code.set(lobe);
    code[lobe.length] = BASIS.EMPTY_GAIN;
    return code;
  }

  /** The table of the rests of codes, one for each channel. */
  table(codes: readonly Float32Array[]): FTable {
    const { width, lobe } = this;
    const { rows, bounds } = this.weights;
    const terms = bounds.length - 1;
    const stride = codes.length * terms;
    const logs = new Float32Array(NODES * stride);
    codes.forEach((code, channel) => {
      const numbers = Float64Array.of(1, ...code.subarray(lobe));
      for (let node = 0, at = 0; node < NODES; node++, at += width)
        for (let term = 0; term < terms; term++) {
          const end = bounds[term + 1];
          let sum = 0;
          for (let k = bounds[term]; k < end; k++) sum += rows[at + k] * numbers[k];
          logs[node * stride + channel * terms + term] = sum;
        }
    });
    const table = { logs, besideLobe: true, isOfCodes: true };
    return terms === 1
      ? table
      : { ...table, stretches: codes.map((code) => code[code.length - 1]) };
  }

  /**
   * The texels of the texture of shader code, four numbers each; see `basis_texture` of Python's
   * `export.rest`. Along its x axis, w is repeated for blocks of numbers: b, then the functions
   * without the first, which is one.
   */
  texels(): Float32Array<ArrayBuffer> {
    const { width } = this;
    const { rows } = this.weights;
    const inner = TABLE.SHAPE[2];
    const blocks = Math.ceil((width - 1) / 4);
    const texels = new Float32Array(NODES * blocks * 4);
    for (let node = 0; node < NODES; node++) {
      const [outer, w] = [Math.floor(node / inner), node % inner];
      for (let n = 0; n < width - 1; n++) {
        const texel = (outer * blocks + Math.floor(n / 4)) * inner + w;
        texels[4 * texel + (n % 4)] = rows[node * width + (n === 0 ? 0 : n + 1)];
      }
    }
    return texels;
  }

  /** The functions (count, 1 + K) at pairs, times their factors, without a stretch. */
  private functions(pairs: Pairs, count: number): Float64Array {
    const { width } = this;
    const { rows, bounds } = this.weights;
    const values = new Float64Array(count * width);
    const cell = new Cell(this.widths);
    for (let i = 0; i < count; i++) {
      cell.set(pairs, i);
      const to = i * width;
      for (let corner = 0; corner < 8; corner++) {
        const [share, from] = [cell.shares[corner], cell.nodes[corner] * width];
        for (let k = 0; k < width; k++) values[to + k] += share * rows[from + k];
      }
      cell.factors.forEach((factor, term) => {
        for (let k = bounds[term]; k < bounds[term + 1]; k++) values[to + k] *= factor;
      });
    }
    return values;
  }
}

/** What a lobe leaves of f, at least zero. */
export function difference(f: Float64Array, top: Float64Array): Float64Array {
  return f.map((value, i) => Math.max(value - top[i], 0));
}
