/** Tables over directions: their cells, and materials by tables of ln f; see Python's `core.table`. */

import { CHANNELS } from "./channels";
import type { Pairs, Widths } from "./features";
import { nodeDirections, TABLE, tableCoordinates, tableCoordinates2 } from "./formulas";
import { fromHalf, toHalf } from "./half";

/** A material's table, by which f is evaluated. */
export interface FTable {
  /** ln f (nodes, 3). */
  readonly logs: Float32Array;
  /** Whether f is the lobe of the codes plus the table. */
  readonly besideLobe: boolean;
  /** Whether the codes give the same f, so that files leave it out; false if left out. */
  readonly isOfCodes?: boolean;
}

/** Number of nodes of a table of one GGX width or two. */
export function nodeCount(widths: Widths): number {
  return TABLE.SHAPES[widths].reduce<number>((product, count) => product * count, 1);
}

/** Numbers of a table of three channels and one width. */
export const TABLE_SIZE = nodeCount(1) * CHANNELS;

/** Pairs of directions (N, 3) of the nodes of one width, the last axis fastest. */
export function nodePairs(): { wi: Float32Array; wo: Float32Array } {
  const [U, V, W] = TABLE.SHAPES[1];
  const count = U * V * W;
  const [wi, wo] = [new Float32Array(3 * count), new Float32Array(3 * count)];
  const pair = new Float64Array(6);
  for (let i = 0; i < count; i++) {
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
  return { wi, wo };
}

/** A logarithm within the range of tables. */
export function clampedLog(logarithm: number): number {
  return Math.min(Math.max(logarithm, TABLE.MIN_LOG), TABLE.MAX_LOG);
}

/** The logarithms, in half precision, of values [1/sr] of three channels at `nodePairs`. */
export function logsOf(values: readonly Float64Array[]): Float32Array {
  return Float32Array.from({ length: TABLE_SIZE }, (_, at) => {
    const log = Math.log(values[at % CHANNELS][Math.floor(at / CHANNELS)]);
    return fromHalf(toHalf(clampedLog(log)));
  });
}

/** The cell of a table around a pair of directions: its corners, and their shares. */
export class Cell {
  readonly nodes: Int32Array;
  readonly shares: Float64Array;
  private readonly shape: readonly number[];
  private readonly coordinates: typeof tableCoordinates;
  private readonly place: Float64Array;

  constructor(widths: Widths) {
    this.shape = TABLE.SHAPES[widths];
    this.coordinates = widths === 1 ? tableCoordinates : tableCoordinates2;
    this.place = new Float64Array(this.shape.length);
    this.nodes = new Int32Array(2 ** this.shape.length);
    this.shares = new Float64Array(this.nodes.length);
  }

  /** Set the cell to that of pair `i`. */
  set({ directions: w }: Pairs, i: number): void {
    const { shape, place, nodes, shares } = this;
    const k = 6 * i;
    this.coordinates(w[k], w[k + 1], w[k + 2], w[k + 3], w[k + 4], w[k + 5], place, 0);
    nodes[0] = 0;
    shares[0] = 1;
    for (let axis = 0, known = 1; axis < shape.length; axis++, known *= 2) {
      const count = shape[axis];
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
}

/** Put the values (count, 3) [1/sr] of a table at the first pairs into an array. */
export function tableValues(
  { logs }: FTable,
  pairs: Pairs,
  count: number,
  out: Float64Array,
): void {
  const cell = new Cell(pairs.widths);
  const { nodes, shares } = cell;
  for (let i = 0; i < count; i++) {
    cell.set(pairs, i);
    let [red, green, blue] = [0, 0, 0];
    for (let corner = 0; corner < nodes.length; corner++) {
      const at = CHANNELS * nodes[corner];
      const share = shares[corner];
      red += share * logs[at];
      green += share * logs[at + 1];
      blue += share * logs[at + 2];
    }
    const to = CHANNELS * i;
    out[to] = Math.exp(red);
    out[to + 1] = Math.exp(green);
    out[to + 2] = Math.exp(blue);
  }
}
