/** OpenEXR files, which others have written. */

import { FloatType, RGBAFormat } from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { FileError } from "../core/safetensors";
import type { Panorama } from "./panorama";

/**
 * Read an OpenEXR file with the channels R, G and B, or Y. Values below 0 become 0.
 *
 * The library may run for ever where the compressed numbers are damaged.
 *
 * @throws FileError if it is another file, damaged, or of a kind that the library does not know.
 */
export function readExr(bytes: Uint8Array): Panorama {
  const loader = new EXRLoader().setDataType(FloatType).setOutputFormat(RGBAFormat);
  let read: { width: number; height: number; data: ArrayLike<number> };
  try {
    checkHeader(bytes);
    read = loader.parse(bytes.slice().buffer) as typeof read;
  } catch {
    throw new FileError(
      "This .exr file is damaged, or has several parts or a compression that the page cannot read.",
    );
  }
  const { width, height, data } = read;
  const pixels = new Float32Array(3 * width * height);
  for (let place = 0; place < width * height; place++) {
    const row = height - 1 - Math.floor(place / width); // the library's lowest comes first
    for (let k = 0; k < 3; k++) {
      const value = data[4 * (row * width + (place % width)) + k]!;
      pixels[3 * place + k] = Number.isFinite(value) ? Math.max(value, 0) : 0;
    }
  }
  return { width, height, pixels };
}

/**
 * Read over the attributes of an OpenEXR file, each a name, a type, a size and a value: the library
 * would look for the end of a text beyond the end of the file for ever.
 *
 * @throws RangeError if the file ends before them.
 */
function checkHeader(bytes: Uint8Array): void {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const after = (start: number) => {
    const end = bytes.indexOf(0, start);
    if (end < 0) throw new RangeError();
    return end + 1;
  };
  for (let at = 8; view.getUint8(at) !== 0; ) {
    const size = after(after(at));
    at = size + 4 + view.getUint32(size, true);
  }
}
