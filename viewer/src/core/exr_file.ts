/** OpenEXR files, which others have written. */

import parseExr from "parse-exr";
import { FileError } from "./safetensors";

/** The number by which `parseExr` knows single precision. */
const FLOAT = 1015;

/** A picture (height, width, 3) of linear values, the first row at the top. */
export interface ExrPicture {
  width: number;
  height: number;
  pixels: Float32Array;
}

/**
 * Read an OpenEXR file of one part with the channels R, G and B, or Y. Values below 0 become 0.
 *
 * The library may run for ever where the compressed numbers are damaged.
 *
 * @throws FileError if it is another file, damaged, or of a kind that the library does not know.
 */
export function readExr(bytes: Uint8Array): ExrPicture {
  let read: ReturnType<typeof parseExr>;
  try {
    checkHeader(bytes);
    read = parseExr(bytes.slice().buffer, FLOAT);
  } catch {
    throw new FileError(
      "This .exr file is damaged, or has several parts or a compression that the page cannot read.",
    );
  }
  const { width, height, data } = read;
  const channels = data.length / (width * height);
  const pixels = new Float32Array(3 * width * height);
  for (let at = 0; at < pixels.length; at++) {
    const [place, channel] = [Math.floor(at / 3), channels === 1 ? 0 : at % 3];
    const row = height - 1 - Math.floor(place / width); // the library's lowest comes first
    const value = data[(row * width + (place % width)) * channels + channel]!;
    pixels[at] = Number.isFinite(value) ? Math.max(value, 0) : 0;
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
