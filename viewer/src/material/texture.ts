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
export type Wrap = "repeat" | "mirror" | "clamp";

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
  /** The affine map from uv to the texture's coordinates, row by row. */
  toTexture: readonly number[];
  wrap: Wrap;
  /** Whether the nearest texel is taken, without interpolation. */
  nearest: boolean;
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
  const { width, height } = description;
  if (!isCount(width) || !isCount(height) || width * height === 0) throw damaged();
  const layout = layoutOf(description, latentSize);
  const range = (name: string) => file.numbers(name, [latentSize]);
  const [lowest, step] = [range("lowest"), range("step")];
  const numbers = layout.high.map((high, number) =>
    Array.from({ length: CHANNELS }, (_, colour) => {
      const channel = layout.channels === 1 ? 0 : colour;
      const first = layout.same[number] ? 0 : layout.shared + channel * layout.stride;
      const place = (byte: number) => (byte < 0 ? -1 : first + byte);
      const low = layout.low[number]!;
      return { lowest: lowest[number]!, step: step[number]!, high: place(high), low: place(low) };
    }),
  );
  const usedBytes = layout.shared + layout.channels * layout.stride;
  const all = numbers.flat().flatMap(({ high, low }) => [high, low]);
  if (usedBytes > layout.texelBytes || all.some((byte) => byte >= usedBytes)) throw damaged();
  return {
    id: nameOf(bytes),
    file: bytes,
    size: [width, height],
    texels: file.bytes("texels", "U8", [width * height, layout.texelBytes]),
    texelBytes: layout.texelBytes,
    usedBytes,
    numbers,
    ...placeOf(description),
  };
}

/** The mean codes (3, L) of a texture, for what has no place on the surface. */
export function meanCodes(texture: CodeTexture): Float32Array {
  const { texels, texelBytes, numbers } = texture;
  const sums = new Float64Array(texelBytes);
  for (let at = 0; at < texels.length; at++) sums[at % texelBytes]! += texels[at]!;
  const mean = sums.map((sum) => (sum * texelBytes) / texels.length);
  const codes = new Float32Array(CHANNELS * numbers.length);
  numbers.forEach((channels, number) => {
    channels.forEach(({ lowest, step, high, low }, channel) => {
      const steps = high < 0 ? 0 : low < 0 ? mean[high]! : 256 * mean[high]! + mean[low]!;
      codes[channel * numbers.length + number] = lowest + step * steps;
    });
  });
  return codes;
}

function layoutOf(description: Fields, size: number) {
  const layout = Object(description.layout) as Fields;
  const { channels, shared, stride, texel_bytes: texelBytes } = layout;
  const { high, low, same } = layout;
  const isPlaces = (value: unknown): value is number[] =>
    Array.isArray(value) && value.length === size && value.every((x) => Number.isInteger(x));
  if (!isPlaces(high) || !isPlaces(low) || !Array.isArray(same) || same.length !== size)
    throw damaged();
  if (![channels, shared, stride, texelBytes].every(isCount)) throw damaged();
  if (channels !== 1 && channels !== CHANNELS)
    throw new Refusal("It has other channels than red, green and blue.");
  return {
    channels,
    shared: shared as number,
    stride: stride as number,
    texelBytes: texelBytes as number,
    high,
    low,
    same: same.map(Boolean),
  };
}

function placeOf(description: Fields): Pick<CodeTexture, "toTexture" | "wrap" | "nearest"> {
  const { to_texture: rows, wrap, nearest } = Object(description.place) as Fields;
  const toTexture = (Array.isArray(rows) ? rows.flat() : []) as unknown[];
  const isMatrix = toTexture.length === 6 && toTexture.every(Number.isFinite);
  if (!isMatrix || (wrap !== "repeat" && wrap !== "mirror" && wrap !== "clamp")) throw damaged();
  return { toTexture: toTexture as number[], wrap, nearest: nearest === true };
}

function isCount(value: unknown): value is number {
  return Number.isSafeInteger(value) && (value as number) >= 0;
}

function damaged(): Refusal {
  return new Refusal("It is damaged or no texture that Urushi has saved.");
}
