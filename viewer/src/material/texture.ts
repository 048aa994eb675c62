/** Textures of latent codes: files that the method `save` of Python's plugins writes. */

import { CHANNELS } from "../core/channels";
import type { Networks } from "../core/core";
import type { Fields, TensorFile } from "../core/safetensors";
import { Refusal } from "../refusal";
import { nameOf } from "../save/zip";

/** A number of a code in one channel: linear in a texel's bytes, which are in [0, 255]. */
export interface LinearNumber {
  /** Its value where the bytes are zero. */
  lowest: number;
  /** Its change for a step of the low byte; without one, of the high byte. */
  step: number;
  /** Places of its bytes in a texel; -1: there is none. */
  high: number;
  low: number;
}

/** How texture coordinates go on beyond [0, 1]. */
const WRAPS = ["repeat", "mirror", "clamp"] as const;

export type Wrap = (typeof WRAPS)[number];

/** A texture of codes. */
export interface CodeTexture {
  /** Names its file in the page's state: the check sum. */
  id: string;
  /** The file. */
  file: Uint8Array<ArrayBuffer>;
  /** Width and height. */
  size: readonly [number, number];
  /** Bytes of the texels, `texelBytes` each, of which `usedBytes` hold numbers. */
  texels: Uint8Array;
  texelBytes: number;
  usedBytes: number;
  /** Numbers of a code, of red, green and blue each. */
  numbers: readonly (readonly LinearNumber[])[];
  /** The affine map from uv to the texture's coordinates, column by column. */
  toTexture: readonly number[];
  wrap: Wrap;
  /** Whether the nearest texel is taken, without interpolation. */
  nearest: boolean;
}

/** What Python's `textures.packing` writes about a texture. */
interface Description {
  width: number;
  height: number;
  layout: {
    channels: number;
    /** Bytes that all channels share, and those of one channel behind them. */
    shared: number;
    stride: number;
    texel_bytes: number;
    /** For each number of a code its bytes, -1: none, and whether all channels share them. */
    high: number[];
    low: number[];
    same: boolean[];
  };
  place: { to_texture: number[][]; wrap: Wrap; nearest: boolean };
}

/** Version of the format that Python writes. */
const VERSION = 4;

/** Whether a file is a texture of codes. */
export function isTexture({ description }: TensorFile): boolean {
  return description.kind === "texture";
}

/**
 * The texture of a file and its bytes.
 *
 * @throws Refusal if it is damaged, of another version, or of other networks.
 */
export function readTexture(
  file: TensorFile,
  bytes: Uint8Array<ArrayBuffer>,
  { latentSize, fingerprint }: Pick<Networks, "latentSize" | "fingerprint">,
): CodeTexture {
  const { description } = file;
  if (description.version !== VERSION)
    throw new Refusal("It is a texture of another version of Urushi; save it again.");
  if (description.weights !== fingerprint)
    throw new Refusal("It was made with other networks; save the texture again.");
  if (!isDescription(description, latentSize))
    throw new Refusal("The description of the texture is damaged; save it again.");
  const { width, height, layout, place } = description;
  const { channels, shared, stride, texel_bytes: texelBytes, high, low, same } = layout;
  if (channels !== 1 && channels !== CHANNELS)
    throw new Refusal("It has other channels than red, green and blue.");
  const range = (name: string) => file.numbers(name, [latentSize]);
  const [lowest, step] = [range("lowest"), range("step")];
  const numbers = high.map((_, number) =>
    Array.from({ length: CHANNELS }, (_, colour) => {
      const first = same[number] ? 0 : shared + (channels === 1 ? 0 : colour) * stride;
      const at = (byte: number) => (byte < 0 ? -1 : first + byte);
      const places = { high: at(high[number]), low: at(low[number]) };
      return { lowest: lowest[number], step: step[number], ...places };
    }),
  );
  return {
    id: nameOf(bytes),
    file: bytes,
    size: [width, height],
    texels: file.bytes("texels", "U8", [width * height, texelBytes]),
    texelBytes,
    usedBytes: shared + channels * stride,
    numbers,
    toTexture: [0, 1, 2].flatMap((column) => place.to_texture.map((row) => row[column])),
    wrap: place.wrap,
    nearest: place.nearest,
  };
}

/** Whether all that is read of a description is there and within its range. */
function isDescription(fields: Fields, latentSize: number): fields is Fields & Description {
  const { width, height, layout, place } = fields;
  const { channels, shared, stride, texel_bytes, high, low, same } = Object(layout);
  const { to_texture, wrap } = Object(place);
  const isList = (value: unknown, size: number, isItem: (item: unknown, at: number) => boolean) =>
    Array.isArray(value) && value.length === size && value.every(isItem);
  const isCount = (value: unknown, least = 0) => Number.isInteger(value) && Number(value) >= least;
  const isByte = (byte: unknown, number: number) =>
    isCount(byte, -1) && Number(byte) < (same[number] ? shared : stride);
  return (
    [width, height].every((size) => isCount(size, 1)) &&
    [shared, stride].every((size) => isCount(size)) &&
    shared + channels * stride <= texel_bytes &&
    isList(same, latentSize, (value) => typeof value === "boolean") &&
    [high, low].every((bytes) => isList(bytes, latentSize, isByte)) &&
    isList(to_texture, 2, (row) => isList(row, 3, Number.isFinite)) &&
    WRAPS.includes(wrap)
  );
}

/** The mean codes (3, L) of a texture, for what has no place on the surface. */
export function meanCodes(texture: CodeTexture): Float32Array {
  const { texels, texelBytes, numbers } = texture;
  const sums = new Float64Array(texelBytes);
  for (let at = 0; at < texels.length; at++) sums[at % texelBytes] += texels[at];
  const mean = sums.map((sum) => (sum * texelBytes) / texels.length);
  const codes = new Float32Array(CHANNELS * numbers.length);
  numbers.forEach((channels, number) => {
    channels.forEach(({ lowest, step, high, low }, channel) => {
      const steps = high < 0 ? 0 : low < 0 ? mean[high] : 256 * mean[high] + mean[low];
      codes[channel * numbers.length + number] = lowest + step * steps;
    });
  });
  return codes;
}
