/** Panoramas of files: Radiance's .hdr and OpenEXR, by the loaders of three.js. */

import { FloatType, RGBAFormat } from "three";
import { EXRLoader } from "three/addons/loaders/EXRLoader.js";
import { HDRLoader } from "three/addons/loaders/HDRLoader.js";
import { FileError } from "../core/safetensors";
import { type LitPanorama, type Picture, withoutLights } from "./panorama";

const MOST_PIXELS = 8192 * 4096;

/** Suffixes of panoramas. */
export type PanoramaSuffix = "exr" | "hdr";

/**
 * The panorama of a file without its bright lights, and these.
 *
 * @throws FileError if it is damaged, no panorama or too large.
 */
export function readPanorama(bytes: Uint8Array, suffix: PanoramaSuffix): LitPanorama {
  const panorama = readPicture(bytes, suffix);
  const { width, height } = panorama;
  if (width * height > MOST_PIXELS || width < 2 || height < 1)
    throw new FileError("This panorama is too large; up to 8192 by 4096 pixels can be read.");
  if (Math.abs(width / height - 2) > 0.05)
    throw new FileError("This picture is no panorama, whose width is twice its height.");
  return withoutLights(panorama);
}

/**
 * The picture of a file. Values below 0 become 0.
 *
 * The library may run for ever where the compressed numbers of OpenEXR are damaged.
 *
 * @throws FileError if it is another file, damaged, or of a kind that the library does not know.
 */
export function readPicture(bytes: Uint8Array, suffix: PanoramaSuffix): Picture {
  let read: { width: number; height: number; data: ArrayLike<number>; header?: string };
  try {
    if (suffix === "exr") checkHeader(bytes);
    const loader = suffix === "hdr" ? new HDRLoader() : new EXRLoader().setOutputFormat(RGBAFormat);
    read = loader.setDataType(FloatType).parse(bytes.slice().buffer) as typeof read;
    if (read.data.length !== 4 * read.width * read.height) throw new RangeError();
    if (suffix === "hdr") checkRuns(bytes.subarray(read.header!.length), read);
  } catch {
    throw new FileError(
      `This .${suffix} file is damaged, or of a kind that the page cannot read, as one of several parts.`,
    );
  }
  const { width, height, data } = read;
  const isUpward = suffix === "exr"; // the library's lowest row comes first
  const factor = suffix === "hdr" ? 255 / 256 : 1; // Ward's mantissas are shares of 256
  const pixels = new Float32Array(3 * width * height);
  for (let place = 0; place < width * height; place++) {
    const row = Math.floor(place / width);
    const from = (isUpward ? height - 1 - row : row) * width + (place % width);
    for (let k = 0; k < 3; k++) {
      const value = factor * data[4 * from + k];
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

/**
 * Read over the rows of a Radiance file, each four bytes and runs of its four bands: the library would
 * leave the rows black that are missing.
 *
 * @throws RangeError if the file ends before them.
 */
function checkRuns(rows: Uint8Array, { width, height }: { width: number; height: number }): void {
  if (width < 8 || rows[0] !== 2 || rows[1] !== 2 || rows[2] > 127) return; // no runs
  let at = 0;
  for (let row = 0; row < height; row++) {
    at += 4;
    for (let left = 4 * width; left > 0; ) {
      if (at >= rows.length) throw new RangeError();
      const count = rows[at];
      left -= count % 128 || 128;
      at += 1 + (count > 128 ? 1 : count);
    }
  }
  if (at > rows.length) throw new RangeError();
}
