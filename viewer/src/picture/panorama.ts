/** Panoramas: reading Radiance's .hdr files, and taking the bright lights out of them. */

import { Refusal } from "../refusal";
import { dot } from "./vectors";

/** A picture of all directions: width twice the height, the zenith in the first row. */
export interface Panorama {
  width: number;
  height: number;
  /** (height, width, 3) linear radiance. */
  pixels: Float32Array;
}

/** A light that is so small and bright that it is evaluated directly. */
export interface Light {
  direction: readonly [number, number, number];
  /** Irradiance at normal incidence, red, green and blue. */
  power: readonly [number, number, number];
}

/** The shader has room for so many. */
export const MOST_LIGHTS = 4;

const MOST_PIXELS = 8192 * 4096;

/**
 * Read a .hdr file (Ward 1991), plain or run-length coded.
 *
 * @throws Refusal if it is another file, truncated, or too large.
 */
export function readHdr(bytes: Uint8Array): Panorama {
  const header = new TextDecoder("latin1").decode(bytes.subarray(0, 4096));
  const size = /\n\n-Y (\d+) \+X (\d+)\n/.exec(header);
  if (!header.startsWith("#?") || size === null)
    throw new Refusal("This is no .hdr panorama that the page can read.");
  const [height, width] = [Number(size[1]), Number(size[2])];
  checkSize(width, height);
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

/** @throws Refusal if a picture of this size is no panorama, or too large a one. */
export function checkSize(width: number, height: number): void {
  if (width * height > MOST_PIXELS || width < 2 || height < 1)
    throw new Refusal("This panorama is too large; up to 8192 by 4096 pixels can be read.");
  if (Math.abs(width / height - 2) > 0.05)
    throw new Refusal("This picture is no panorama, whose width is twice its height.");
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

function truncated(): Refusal {
  return new Refusal("This .hdr file is damaged or incomplete.");
}

/** A pixel is a bright light from so many times the mean. */
const BRIGHT = 60;

/** Lights of this width are one [cosine]. */
const SAME_LIGHT = Math.cos((5 * Math.PI) / 180);

/** The panorama without its small bright lights, and these. */
export function withoutLights(panorama: Panorama): { panorama: Panorama; lights: Light[] } {
  const { width, height, pixels } = panorama;
  const grey = (at: number) => (pixels[at]! + pixels[at + 1]! + pixels[at + 2]!) / 3;
  let sum = 0;
  let weights = 0;
  for (let y = 0; y < height; y++) {
    const weight = Math.sin((Math.PI * (y + 0.5)) / height);
    for (let x = 0; x < width; x++) sum += weight * Math.min(grey(3 * (y * width + x)), 1e4);
    weights += weight * width;
  }
  const limit = (BRIGHT * sum) / weights;

  const found: { direction: number[]; power: number[]; sum: number[] }[] = [];
  const kept = pixels.slice();
  for (let y = 0; y < height; y++) {
    const theta = (Math.PI * (y + 0.5)) / height;
    const solidAngle = (2 * Math.PI * Math.PI * Math.sin(theta)) / (width * height);
    for (let x = 0; x < width; x++) {
      const at = 3 * (y * width + x);
      const value = grey(at);
      if (value <= limit) continue;
      const phi = (2 * Math.PI * (x + 0.5)) / width;
      const way = [
        Math.sin(theta) * Math.sin(phi),
        Math.sin(theta) * Math.cos(phi),
        Math.cos(theta),
      ];
      let light = found.find((one) => dot(one.direction, way) > SAME_LIGHT);
      if (light === undefined) {
        if (found.length === MOST_LIGHTS) continue; // it stays in the panorama
        light = { direction: way, power: [0, 0, 0], sum: [0, 0, 0] };
        found.push(light);
      }
      for (let k = 0; k < 3; k++) {
        const taken = pixels[at + k]! * (1 - limit / value);
        light.power[k]! += taken * solidAngle;
        light.sum[k]! += way[k]! * value * solidAngle;
        kept[at + k]! -= taken;
      }
      const length = Math.hypot(...light.sum);
      light.direction = light.sum.map((part) => part / length);
    }
  }
  const lights = found.map(({ direction, power }) => ({
    direction: [direction[0]!, direction[1]!, direction[2]!] as const,
    power: [power[0]!, power[1]!, power[2]!] as const,
  }));
  return { panorama: { width, height, pixels: kept }, lights };
}
