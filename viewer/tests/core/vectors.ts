/** The weights that Urushi ships, pairs of directions, and relative errors. */

import { readFileSync } from "node:fs";
import { sequencePoint } from "../../src/core/sequence";

/** The bytes of a file. */
export function bytesOf(path: string | URL): ArrayBuffer {
  const bytes = readFileSync(path);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
}

export const SHIPPED = new URL(
  "../../../src/urushi/nets/weights/default.safetensors",
  import.meta.url,
);

/** Those for anisotropic materials. */
export const SHIPPED_ANISOTROPIC = new URL("./anisotropic.safetensors", SHIPPED);

/** Pairs of unit vectors (count, 3) above the horizon at all azimuths; every other is near a mirror's. */
export function pairs(count = 64): [wi: Float32Array, wo: Float32Array] {
  const [wi, wo]: [number[], number[]] = [[], []];
  const at = (z: number, turn: number) => {
    const r = Math.sqrt(1 - z * z);
    return [r * Math.cos(2 * Math.PI * turn), r * Math.sin(2 * Math.PI * turn), z];
  };
  for (let k = 0; k < count; k++) {
    const [a, b, c] = sequencePoint(k + 1, [0.5, 0.5, 0.5]);
    const one = at(0.02 + 0.97 * a, b);
    const half = at(1 - 0.02 * c, c);
    const twice = 2 * one.reduce((sum, x, i) => sum + x * half[i], 0);
    const mirrored = one.map((x, i) => twice * half[i] - x);
    wi.push(...one);
    wo.push(...(k % 2 === 0 && mirrored[2] > 0.004 ? mirrored : at(0.02 + 0.97 * c, a)));
  }
  return [Float32Array.from(wi), Float32Array.from(wo)];
}

/**
 * The greatest difference of two arrays, relative to the expected numbers.
 *
 * @param least numbers smaller than this are compared as if they were it.
 */
export function relativeError(
  found: ArrayLike<number>,
  expected: ArrayLike<number>,
  least = 0,
): number {
  if (found.length !== expected.length) return Number.POSITIVE_INFINITY;
  let greatest = 0;
  for (let i = 0; i < expected.length; i++) {
    const difference = Math.abs(found[i] - expected[i]);
    const error = difference === 0 ? 0 : difference / Math.max(Math.abs(expected[i]), least);
    if (!(error <= greatest)) greatest = error; // also NaN, which then stays
  }
  return greatest;
}
