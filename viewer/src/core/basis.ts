/**
 * The linear basis: f of a code without its lobe, by functions over directions.
 *
 *     ln f(wi, wo) = b(x) + sum_k c_k U_k(x)
 *
 * x are the coordinates of tables, and the numbers c_k follow those of the lobe in a code. The first
 * function is one; see Python's `nets.basis`.
 */

import { CHANNELS } from "./channels";
import { fittedCode } from "./code_fit";
import { Cell, clampedLog, type FTable, nodeCount } from "./f_table";
import type { Pairs, Widths } from "./features";
import { BASIS, TABLE } from "./formulas";
import { lobeValues } from "./lobe";
import { probePairs } from "./probe_pairs";
import { type AtPairs, difference, type Rests } from "./rests";

/** The parameters of a basis of K functions. */
export interface BasisWeights {
  readonly widths: Widths;
  /** (nodes, 1 + K): b, then the functions. */
  readonly rows: Float32Array;
  /** (N) share of each probe pair in integrals over pairs. */
  readonly measure: Float64Array;
  /** (K, K) inverse covariance of the codes of the training materials. */
  readonly prior: Float64Array;
}

export class Basis implements Rests {
  readonly widths: Widths;
  readonly probes: Pairs;
  /** Numbers of a row, 1 + K. */
  private readonly width: number;
  private readonly atProbes: AtPairs;

  constructor(
    private readonly weights: BasisWeights,
    private readonly lobe: number,
  ) {
    this.widths = weights.widths;
    this.width = weights.rows.length / nodeCount(weights.widths);
    this.probes = probePairs(weights.measure.length, weights.widths);
    this.atProbes = this.at(this.probes);
  }

  /** The functions (count, 1 + K). */
  at(pairs: Pairs, count = pairs.capacity): AtPairs {
    const { width } = this;
    const { rows } = this.weights;
    const values = new Float64Array(count * width);
    const cell = new Cell(this.widths);
    for (let i = 0; i < count; i++) {
      cell.set(pairs, i);
      cell.nodes.forEach((node, corner) => {
        const [share, from, to] = [cell.shares[corner], node * width, i * width];
        for (let k = 0; k < width; k++) values[to + k] += share * rows[from + k];
      });
    }
    return { count, values };
  }

  values(code: ArrayLike<number>, { count, values }: AtPairs): Float64Array {
    const { width, lobe } = this;
    const result = new Float64Array(count);
    for (let i = 0, at = 0; i < count; i++, at += width) {
      let log = values[at];
      for (let k = 1; k < width; k++) log += values[at + k] * code[lobe + k - 1];
      result[i] = Math.exp(clampedLog(log));
    }
    return result;
  }

  encode(lobe: Float32Array, f: Float64Array): Float32Array {
    const { measure, prior } = this.weights;
    const top = lobeValues(lobe, this.probes);
    const numbers = fittedCode(this.atProbes.values, measure, prior, difference(f, top), top);
    return Float32Array.of(...lobe, ...numbers);
  }

  without(lobe: Float32Array): Float32Array {
    const code = new Float32Array(lobe.length + this.width - 1);
    code.set(lobe);
    code[lobe.length] = BASIS.EMPTY_GAIN;
    return code;
  }

  /**
   * The texels of the texture of shader code, four numbers each; see `basis_texture` of Python's
   * `export.rest`. Along its x axis, w is repeated for blocks of numbers: b, then the functions
   * without the first, which is one.
   */
  texels(): Float32Array<ArrayBuffer> {
    const { width } = this;
    const { rows } = this.weights;
    const [inner] = TABLE.SHAPES[this.widths].slice(-1) as [number];
    const blocks = Math.ceil((width - 1) / 4);
    const texels = new Float32Array((rows.length / width) * blocks * 4);
    for (let node = 0; node * width < rows.length; node++) {
      const [outer, w] = [Math.floor(node / inner), node % inner];
      for (let n = 0; n < width - 1; n++) {
        const texel = (outer * blocks + Math.floor(n / 4)) * inner + w;
        texels[4 * texel + (n % 4)] = rows[node * width + (n === 0 ? 0 : n + 1)];
      }
    }
    return texels;
  }

  /** The table of the rests of three codes. */
  table(codes: readonly Float32Array[]): FTable {
    const { width } = this;
    const { rows } = this.weights;
    const [red, green, blue] = codes.map((code) => Float64Array.of(1, ...code.subarray(this.lobe)));
    const logs = new Float32Array((rows.length / width) * CHANNELS);
    for (let at = 0, to = 0; at < rows.length; at += width, to += CHANNELS) {
      let [r, g, b] = [0, 0, 0];
      for (let k = 0; k < width; k++) {
        const value = rows[at + k];
        r += value * red[k];
        g += value * green[k];
        b += value * blue[k];
      }
      logs[to] = clampedLog(r);
      logs[to + 1] = clampedLog(g);
      logs[to + 2] = clampedLog(b);
    }
    return { logs, besideLobe: true, isOfCodes: true };
  }
}
