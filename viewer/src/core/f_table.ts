/** Tables of ln f over directions; see Python's `material.table`. */

import { CHANNELS } from "./channels";
import { DECODER, FEATURES, nodeDirections, TABLE, tableCoordinates } from "./formulas";
import { fromHalf, toHalf } from "./half";

/** A material's table, by which f is evaluated in place of its codes. */
export interface FTable {
  /** ln f (U, V, W, 3), numbers of half precision. */
  readonly logs: Float32Array;
  /** Whether f is the lobe of the codes plus the table. */
  readonly besideLobe: boolean;
}

const [U, V, W] = TABLE.SHAPE;

/** Numbers of a table of three channels. */
export const TABLE_SIZE = U * V * W * CHANNELS;

/** Pairs of directions (N, 3) of the nodes, the last axis fastest. */
export function nodePairs(): { wi: Float32Array; wo: Float32Array } {
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
      const [x, y, z] = [pair[at], pair[at + 1], Math.max(pair[at + 2], FEATURES.MIN_COSINE)];
      const size = Math.hypot(x, y, z);
      target.set([x / size, y / size, z / size], 3 * i);
    }
  }
  return { wi, wo };
}

/** The logarithms of the values [1/sr] of three channels at `nodePairs`. */
export function logsOf(values: readonly Float64Array[]): Float32Array {
  return Float32Array.from({ length: TABLE_SIZE }, (_, at) => {
    const log = Math.log(values[at % CHANNELS][Math.floor(at / CHANNELS)]);
    return fromHalf(toHalf(Math.min(Math.max(log, DECODER.MIN_LOG), DECODER.MAX_LOG)));
  });
}

const at = new Float64Array(3);

/** Put the values [1/sr] of a table for a pair of directions into three places of an array. */
export function tableValues(
  { logs }: FTable,
  directions: ArrayLike<number>,
  from: number,
  out: Float64Array,
  to: number,
): void {
  const d = directions;
  const [x, y, z] = [d[from], d[from + 1], d[from + 2]];
  tableCoordinates(x, y, z, d[from + 3], d[from + 4], d[from + 5], at, 0);
  out.fill(0, to, to + CHANNELS);
  for (let corner = 0; corner < 8; corner++) {
    let [row, weight] = [0, 1];
    for (let axis = 0; axis < 3; axis++) {
      const count = TABLE.SHAPE[axis];
      const place = Math.min(Math.max(at[axis], 0), 1) * (count - 1);
      const index = Math.min(Math.floor(place), count - 2);
      const isUpper = (corner >> axis) & 1;
      row = row * count + index + isUpper;
      weight *= isUpper ? place - index : 1 - place + index;
    }
    for (let k = 0; k < CHANNELS; k++) out[to + k] += weight * logs[row * CHANNELS + k];
  }
  for (let k = 0; k < CHANNELS; k++) out[to + k] = Math.exp(out[to + k]);
}
