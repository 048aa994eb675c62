/** Golden vectors of Python, see `viewer/tests/golden.py`. */

import { readFileSync } from "node:fs";
import type { Stack } from "../../src/core/api";
import { TensorFile } from "../../src/core/safetensors";
import { type MaterialCards, stackOf } from "../../src/material/material";
import { readMaterial } from "../../src/state/read";

const FOLDER = new URL("./golden/", import.meta.url);

/** The bytes of a file beside the tests, or of any other. */
export function bytesOf(path: string | URL): ArrayBuffer {
  const bytes = readFileSync(path);
  return bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.byteLength) as ArrayBuffer;
}

/** The weights that Urushi ships. */
export const SHIPPED = new URL(
  "../../../src/urushi/nets/weights/default.safetensors",
  import.meta.url,
);

/** Those for anisotropic materials. */
export const SHIPPED_ANISOTROPIC = new URL("./anisotropic.safetensors", SHIPPED);

/** Vectors of all stacks. */
export interface Vectors {
  readonly materials: readonly MaterialCards[];
  readonly stacks: readonly Stack[];
  /** An array of a stack, or, without its number, of all. */
  of(name: string, stack?: number): Float32Array;
}

/** Read the vectors of a name. */
export function readVectors(name: string): Vectors {
  const path = new URL(`${name}_vectors.safetensors`, FOLDER);
  const file = new TensorFile(new Uint8Array(bytesOf(path)));
  const materials = (file.description.stacks as unknown[]).map((stack) => readMaterial(stack));
  return {
    materials,
    stacks: materials.map(stackOf),
    of: (key, stack) => {
      const shape = file.shapeOf(key);
      const values = file.numbers(key, shape);
      const size = values.length / (shape[0] ?? 1);
      const part = stack === undefined ? values : values.subarray(stack * size, (stack + 1) * size);
      return Float32Array.from(part);
    },
  };
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
  if (found.length !== expected.length) {
    return Number.POSITIVE_INFINITY;
  }
  let greatest = 0;
  for (let i = 0; i < expected.length; i++) {
    const difference = Math.abs((found[i] ?? 0) - (expected[i] ?? 0));
    const error = difference === 0 ? 0 : difference / Math.max(Math.abs(expected[i] ?? 0), least);
    if (!(error <= greatest)) {
      greatest = error; // also NaN, which then stays
    }
  }
  return greatest;
}
