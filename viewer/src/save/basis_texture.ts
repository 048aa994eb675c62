/** The texture of the basis that exported shader code reads, as files; see Python's `export.rest`. */

import { halfBytes } from "../engine/opened";
import { TABLE } from "../printed/formulas";
import { exrFile } from "./exr";

/** Formats: for graphics hardware, for NumPy, and for OSL. */
export const FORMATS = { dds: "DDS", npy: "NPY", exr: "EXR" } as const;

export type Format = keyof typeof FORMATS;

const [DEPTH, HEIGHT, INNER] = TABLE.SHAPE;

/** The bytes of a file. @param texels as of `NetworkCore.basisTexels`. */
export function basisFile(texels: Float32Array<ArrayBuffer>, format: Format): Blob {
  const width = texels.length / (4 * DEPTH * HEIGHT);
  if (format === "exr") return new Blob([exrFile(imageOf(texels, width))]);
  const header = format === "dds" ? ddsHeader(width) : npyHeader(width);
  return new Blob([header, halfBytes(texels)]);
}

/** A header of a 3D texture of half floats (Microsoft's Programming Guide for DDS). */
function ddsHeader(width: number): Uint8Array<ArrayBuffer> {
  const numbers = new Uint32Array(37);
  // Flags say what is given; the pitch is the size of a row.
  numbers.set([0x20534444, 124, 0x80100f, HEIGHT, width, 8 * width, DEPTH, 1]);
  numbers.set([32, 0x4, 0x30315844], 19); // the format follows: "DX10"
  numbers.set([0x1000, 0x200000], 27); // a texture, of three dimensions
  numbers.set([10, 4, 0, 1, 0], 32); // DXGI_FORMAT_R16G16B16A16_FLOAT, three dimensions
  return new Uint8Array(numbers.buffer);
}

/** The header of an array (NumPy's NEP 1, version 1.0). */
function npyHeader(width: number): Uint8Array<ArrayBuffer> {
  const shape = `(${DEPTH}, ${HEIGHT}, ${width}, 4)`;
  const text = `{'descr': '<f2', 'fortran_order': False, 'shape': ${shape}, }`.padEnd(117);
  return Uint8Array.of(
    0x93,
    ...new TextEncoder().encode("NUMPY\x01\x00v\x00"),
    ...new TextEncoder().encode(`${text}\n`),
  );
}

/** The image for OSL: three numbers a texel; along its rows, v is repeated for w and the numbers. */
function imageOf(texels: Float32Array, width: number) {
  const blocks = Math.ceil((4 * width) / INNER / 3);
  const pixels = new Float32Array(DEPTH * blocks * INNER * HEIGHT * 3);
  for (let node = 0; node < DEPTH * HEIGHT * INNER; node++) {
    const [row, w] = [Math.floor(node / INNER), node % INNER];
    const [u, v] = [Math.floor(row / HEIGHT), row % HEIGHT];
    for (let n = 0; n < (4 * width) / INNER; n++) {
      const from = 4 * (row * width + Math.floor(n / 4) * INNER + w) + (n % 4);
      const pixel = (u * blocks * INNER + Math.floor(n / 3) * INNER + w) * HEIGHT + v;
      pixels[3 * pixel + (n % 3)] = texels[from];
    }
  }
  return { width: blocks * INNER * HEIGHT, height: DEPTH, pixels };
}
