/**
 * The linear basis: g of a code by functions over directions; f is its lobe plus T(wi) T(wo) g,
 * with T of `lobe.passed`.
 *
 *     ln g(wi, wo) = b(x) + sum_k c_k U_k(x)
 *
 * x are the coordinates of tables, and the numbers c_k follow those of the lobe in a code. The first
 * function is one; see Python's `nets.basis`. For two GGX widths, the coordinates are stretched, and
 * the last functions are multiplied by factors of the azimuth. The logarithm of the stretch is the
 * last number of the code.
 */

import { BASIS, TABLE } from "../printed/formulas";
import {
  Cell,
  clampedLog,
  type FTable,
  NODES,
  type Pairs,
  tableValues,
  type Widths,
} from "./f_table";
import { leastSquares } from "./least_squares";

/** The parameters of a basis of K functions. */
export interface BasisWeights {
  readonly widths: Widths;
  /** (nodes, 1 + K): b, then the functions. */
  readonly rows: Float32Array;
  /** The first number of a row that each of `Cell.factors` multiplies, and 1 + K. */
  readonly bounds: readonly number[];
}

/** Stride of the nodes from which the code of an even f is computed. The basis represents it exactly. */
const EVEN_STRIDE = 7;

/** What is known of pairs of directions whatever the code; see `Basis.at`. */
export interface AtPairs {
  readonly pairs: Pairs;
  /** Of one width: the functions (pairs, 1 + K). */
  readonly values: Float64Array;
}

export class Basis {
  readonly widths: Widths;
  /** Numbers of a row, 1 + K. */
  private readonly width: number;
  /** The numbers, behind those of a lobe, of f = 1. */
  private readonly even: Float32Array;

  constructor(
    private readonly weights: BasisWeights,
    private readonly lobe: number,
  ) {
    this.widths = weights.widths;
    this.width = weights.bounds[weights.bounds.length - 1];
    this.even = this.evenNumbers();
  }

  /** What `values` needs of pairs. */
  at(pairs: Pairs): AtPairs {
    return { pairs, values: this.widths === 1 ? this.functions(pairs) : new Float64Array() };
  }

  /** g (pairs) [1/sr] of a code. */
  values(code: Float32Array, { values, pairs }: AtPairs): Float64Array {
    const { width, lobe } = this;
    if (this.widths === 2) return tableValues(this.table([code]), pairs, 1);
    const result = new Float64Array(pairs.count);
    for (let i = 0, at = 0; i < pairs.count; i++, at += width) {
      let log = values[at];
      for (let k = 1; k < width; k++) log += values[at + k] * code[lobe + k - 1];
      result[i] = Math.exp(clampedLog(log));
    }
    return result;
  }

  /** The code of a lobe, and of a rest that is f [1/sr] everywhere. */
  withEven(lobe: Float32Array, f: number): Float32Array {
    const code = Float32Array.of(...lobe, ...this.even);
    if (f > 0) code[lobe.length] += Math.log(f);
    else code.fill(0, lobe.length).fill(BASIS.EMPTY_GAIN, lobe.length, lobe.length + 1);
    return code;
  }

  /** The table of g of codes, one for each channel. */
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

  /** Functions that depend on the azimuth have no share, and there is no stretch. */
  private evenNumbers(): Float32Array {
    const { width } = this;
    const { rows, bounds } = this.weights;
    const size = bounds[1] - 1;
    const count = Math.floor(NODES / EVEN_STRIDE);
    const functions = new Float64Array(count * size);
    const logs = new Float64Array(count);
    for (let row = 0; row < count; row++) {
      const at = row * EVEN_STRIDE * width;
      functions.set(rows.subarray(at + 1, at + 1 + size), row * size);
      logs[row] = -rows[at];
    }
    const numbers = new Float32Array(width - 1 + Number(this.widths === 2));
    numbers.set(leastSquares(functions, logs));
    return numbers;
  }

  /** The functions (pairs, 1 + K) of one width. */
  private functions(pairs: Pairs): Float64Array {
    const { width } = this;
    const { rows } = this.weights;
    const values = new Float64Array(pairs.count * width);
    const cell = new Cell(1);
    for (let i = 0; i < pairs.count; i++) {
      cell.set(pairs, i);
      const to = i * width;
      for (let corner = 0; corner < 8; corner++) {
        const [share, from] = [cell.shares[corner], cell.nodes[corner] * width];
        for (let k = 0; k < width; k++) values[to + k] += share * rows[from + k];
      }
    }
    return values;
  }
}
