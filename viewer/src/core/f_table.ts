/** Pairs of directions, and tables over them of ln f; see Python's `core.table`. */

import {
  facetCosine,
  nodeDirections,
  STRETCHED,
  stretchedCoordinates,
  TABLE,
} from "../printed/formulas";
import { CHANNELS } from "./channels";

/** GGX widths of a surface: one, or two along and across its tangent. */
export type Widths = 1 | 2;

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

/** A material's table, by which f is evaluated. */
export interface FTable {
  /** ln f (nodes, 3); of two widths the terms (nodes, 3, 6), see `Cell.factors`. */
  readonly logs: Float32Array;
  /** Whether f is the lobe of the codes plus the table times T(wi) T(wo), see `lobe.passed`. */
  readonly besideLobe: boolean;
  /** Of two widths: the logarithms (3) of the stretches of the channels. */
  readonly stretches?: readonly number[];
  /** Whether the codes give the same f, so that files leave it out; false if left out. */
  readonly isOfCodes?: boolean;
}

const SHAPE = TABLE.SHAPE;

/** Number of nodes of a table. */
export const NODES = SHAPE.reduce<number>((product, count) => product * count, 1);

/** Numbers of a table of three channels and one width. */
export const TABLE_SIZE = NODES * CHANNELS;

/** Terms of ln f of two widths: one, and as many as there are factors of the azimuth. */
export const TERMS = 1 + STRETCHED.FACTORS;

/** Pairs of directions of the nodes of one width, the last axis fastest. */
export function nodePairs(): Pairs {
  const [U, V, W] = SHAPE;
  const [wi, wo] = [new Float32Array(3 * NODES), new Float32Array(3 * NODES)];
  const pair = new Float64Array(6);
  for (let i = 0; i < NODES; i++) {
    const [u, v, w] = [Math.floor(i / (V * W)), Math.floor(i / W) % V, i % W];
    nodeDirections(u / (U - 1), v / (V - 1), w / (W - 1), pair, 0);
    for (const [target, at] of [
      [wi, 0],
      [wo, 3],
    ] as const) {
      const [x, y, z] = [pair[at], pair[at + 1], Math.max(pair[at + 2], TABLE.MIN_COSINE)];
      const size = Math.hypot(x, y, z);
      target.set([x / size, y / size, z / size], 3 * i);
    }
  }
  return new Pairs(wi, wo);
}

/** A logarithm within the range of tables. */
export function clampedLog(logarithm: number): number {
  return Math.min(Math.max(logarithm, TABLE.MIN_LOG), TABLE.MAX_LOG);
}

/** The cell of a table around a pair of directions: its corners, and their shares. */
export class Cell {
  readonly nodes = new Int32Array(8);
  readonly shares = new Float64Array(8);
  /** Of two widths: one, and the factors of the azimuth by which terms are multiplied. */
  readonly factors: Float64Array;
  /** Coordinates, and the factors behind them. */
  private readonly place = new Float64Array(3 + STRETCHED.FACTORS);

  constructor(widths: Widths) {
    this.factors = new Float64Array(widths === 1 ? 1 : TERMS).fill(1);
  }

  /** Set the cell to that of pair `i`; stretch2: of two widths, the square of the stretch. */
  set({ directions: w }: Pairs, i: number, stretch2 = 1): void {
    const { place, nodes, shares, factors } = this;
    const k = 6 * i;
    const pair = [w[k], w[k + 1], w[k + 2], w[k + 3], w[k + 4], w[k + 5]] as const;
    stretchedCoordinates(stretch2, ...pair, place, 0); // those of one width are not stretched
    for (let term = 1; term < factors.length; term++) factors[term] = place[2 + term];
    nodes[0] = 0;
    shares[0] = 1;
    for (let axis = 0, known = 1; axis < 3; axis++, known *= 2) {
      const count = SHAPE[axis];
      const at = Math.min(Math.max(place[axis], 0), 1) * (count - 1);
      const first = Math.min(Math.floor(at), count - 2);
      const share = at - first;
      for (let corner = 0; corner < known; corner++) {
        const node = nodes[corner] * count + first;
        const whole = shares[corner];
        nodes[corner] = node;
        nodes[corner + known] = node + 1;
        shares[corner] = whole * (1 - share);
        shares[corner + known] = whole * share;
      }
    }
  }

  /** ln f of a channel, by numbers that have `stride` a node. */
  log(logs: Float32Array, channel: number, stride: number): number {
    const { nodes, shares, factors } = this;
    const first = channel * factors.length;
    let log = 0;
    for (let corner = 0; corner < 8; corner++) {
      const at = nodes[corner] * stride + first;
      let sum = logs[at];
      for (let term = 1; term < factors.length; term++) sum += factors[term] * logs[at + term];
      log += shares[corner] * sum;
    }
    return clampedLog(log);
  }
}

/** The values (pairs, channels) [1/sr] of a table at pairs. */
export function tableValues(
  { logs, stretches }: Pick<FTable, "logs" | "stretches">,
  pairs: Pairs,
  channels: number,
): Float64Array {
  const cell = new Cell(stretches === undefined ? 1 : 2);
  const out = new Float64Array(channels * pairs.count);
  const stride = logs.length / NODES;
  const squares = stretches?.map((stretch) => Math.exp(2 * stretch));
  for (let i = 0; i < pairs.count; i++)
    for (let channel = 0; channel < channels; channel++) {
      const isNew = channel === 0 || (squares && squares[channel] !== squares[channel - 1]);
      if (isNew) cell.set(pairs, i, squares?.[channel]);
      out[channels * i + channel] = Math.exp(cell.log(logs, channel, stride));
    }
  return out;
}
