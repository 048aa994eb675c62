/** Measured BRDFs, recognised by their contents. */

import type { Pairs } from "../features";
import { FileError } from "../safetensors";
import type { Direction } from "./half_vector";
import { isMerl, Merl } from "./merl";
import { Rgl } from "./rgl";
import { isTensorFile } from "./rgl_file";

/** A measured isotropic BRDF. */
export interface Measured {
  /** Whether exchanged directions give the same value. */
  readonly isReciprocal: boolean;
  /** Linear RGB [1/sr], without cosine, for unit vectors above the horizon. */
  f(wi: Direction, wo: Direction): readonly [number, number, number];
}

/**
 * Read a MERL table or an isotropic RGL material.
 *
 * @throws FileError if the file is damaged, anisotropic or of another format.
 */
export function readMeasured(file: ArrayBuffer): Measured {
  if (isTensorFile(file)) return new Rgl(file);
  if (isMerl(file)) return new Merl(file);
  throw new FileError(
    `The file (${file.byteLength} bytes) is neither a MERL table (90 x 90 x 180) nor an RGL material.`,
  );
}

/**
 * Values [1/sr] at N pairs of directions above the horizon, one array (N) for each channel.
 *
 * They are the means over the exchange of the directions and over mirror images.
 */
export function valuesAt(
  measured: Measured,
  { capacity: count, directions }: Pairs,
): [Float64Array, Float64Array, Float64Array] {
  const column = () => new Float64Array(count);
  const values: [Float64Array, Float64Array, Float64Array] = [column(), column(), column()];
  for (let i = 0; i < count; i++) {
    const [a, b] = [unit(directions, 6 * i), unit(directions, 6 * i + 3)];
    const pairs: [Direction, Direction][] = [[a, b]];
    if (!measured.isReciprocal) {
      const [x, y] = [mirrored(a), mirrored(b)];
      pairs.push([b, a], [x, y], [y, x]);
    }
    for (const pair of pairs) {
      measured.f(...pair).forEach((value, channel) => {
        values[channel as 0 | 1 | 2][i] += Math.fround(value) / pairs.length;
      });
    }
  }
  return values;
}

function unit(w: Float64Array, at: number): Direction {
  const [x, y, z] = [w[at], w[at + 1], w[at + 2]] as [number, number, number];
  const size = Math.hypot(x, y, z);
  return [x / size, y / size, z / size];
}

function mirrored([x, y, z]: Direction): Direction {
  return [x, -y, z];
}
