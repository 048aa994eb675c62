/** Panoramas of files: Radiance's .hdr, and OpenEXR by the loader of three.js. */

import { FloatType, RGBAFormat } from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { FileError } from "../core/safetensors";
import { type Light, type Panorama, withoutLights } from "./panorama";

const MOST_PIXELS = 8192 * 4096;

/**
 * The panorama of a file without its bright lights, and these.
 *
 * @param suffix "exr" or "hdr".
 * @throws FileError if it is damaged, no panorama or too large.
 */
export function readPanorama(
  bytes: Uint8Array,
  suffix: string,
): { panorama: Panorama; lights: Light[] } {
  return withoutLights(suffix === "exr" ? checked(readExr(bytes)) : readHdr(bytes));
}

/** A picture whose size is that of a panorama. */
function checked<Picture extends Pick<Panorama, "width" | "height">>(picture: Picture): Picture {
  const { width, height } = picture;
  if (width * height > MOST_PIXELS || width < 2 || height < 1)
    throw new FileError("This panorama is too large; up to 8192 by 4096 pixels can be read.");
  if (Math.abs(width / height - 2) > 0.05)
    throw new FileError("This picture is no panorama, whose width is twice its height.");
  return picture;
}

/**
 * Read a .hdr file (Ward 1991), plain or run-length coded.
 *
 * @throws FileError if it is another file, truncated, or too large.
 */
export function readHdr(bytes: Uint8Array): Panorama {
  const header = new TextDecoder("latin1").decode(bytes.subarray(0, 4096));
  const size = /\n\n-Y (\d+) \+X (\d+)\n/.exec(header);
  if (!header.startsWith("#?") || size === null)
    throw new FileError("This is no .hdr panorama that the page can read.");
  const { width, height } = checked({ width: Number(size[2]), height: Number(size[1]) });
  const pixels = new Float32Array(width * height * 3);
  const row = new Uint8Array(width * 4);
  let at = size.index + size[0].length;
  for (let y = 0; y < height; y++) {
    at = readRow(bytes, at, row, width);
    for (let x = 0; x < width; x++) {
      const exponent = row[4 * x + 3]!;
      const scale = exponent === 0 ? 0 : 2 ** (exponent - 136);
      for (let k = 0; k < 3; k++) pixels[3 * (y * width + x) + k] = row[4 * x + k]! * scale;
    }
  }
  return { width, height, pixels };
}

/** Reads a row's pixels (width, 4) into `row`; returns where the next one begins. */
function readRow(bytes: Uint8Array, start: number, row: Uint8Array, width: number): number {
  let at = start;
  const coded =
    width >= 8 &&
    width < 32768 &&
    bytes[at] === 2 &&
    bytes[at + 1] === 2 &&
    (bytes[at + 2]! << 8) + bytes[at + 3]! === width;
  if (!coded) {
    if (at + 4 * width > bytes.length) throw truncated();
    row.set(bytes.subarray(at, at + 4 * width));
    return at + 4 * width;
  }
  at += 4;
  for (let channel = 0; channel < 4; channel++) {
    for (let x = 0; x < width; ) {
      const count = bytes[at++];
      if (count === undefined) throw truncated();
      const run = count > 128;
      const length = run ? count - 128 : count;
      if (length === 0 || x + length > width || at + (run ? 1 : length) > bytes.length)
        throw truncated();
      for (let i = 0; i < length; i++) row[4 * x++ + channel] = bytes[run ? at : at + i]!;
      at += run ? 1 : length;
    }
  }
  return at;
}

function truncated(): FileError {
  return new FileError("This .hdr file is damaged or incomplete.");
}

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
