import { expect, test } from "vitest";
import { TensorFile, tensorFile } from "../../src/core/safetensors";
import { isTexture, meanCodes, readTexture } from "../../src/material/texture";
import { Refusal } from "../../src/refusal";
import { texelShaderText } from "../../src/save/shader";

const NETWORKS = { latentSize: 3, fingerprint: "8d3f00a1" };

/** Numbers: 16 bits for each channel, the same 8 bits for all channels, and a constant. */
const LAYOUT = {
  channels: 3,
  size: 3,
  high: [0, 0, -1],
  low: [1, -1, -1],
  same: [false, true, false],
  shared: 1,
  stride: 2,
  texel_bytes: 8,
};

const DESCRIPTION = {
  kind: "texture",
  version: 4,
  weights: NETWORKS.fingerprint,
  width: 2,
  height: 1,
  layout: LAYOUT,
  place: {
    to_texture: [
      [0.5, 0, 0.1],
      [0, 1, 0],
    ],
    wrap: "repeat",
    nearest: false,
  },
};

const LOWEST = [-1, 0.25, 3];
const STEP = [0.001, 0.5, 0];

const TEXELS = [...[7, 1, 2, 3, 4, 5, 6, 0], ...[9, 0, 255, 128, 0, 255, 255, 0]];

function file(change: object = {}, texels: number[] = TEXELS): Uint8Array<ArrayBuffer> {
  const range = (values: number[]) => {
    const bytes = new Uint8Array(Float32Array.from(values).buffer);
    return { dtype: "F32", shape: [3], bytes } as const;
  };
  const bytes = new Uint8Array(texels);
  return tensorFile(
    { ...DESCRIPTION, ...change },
    {
      texels: { dtype: "U8", shape: [texels.length / 8, 8], bytes },
      lowest: range(LOWEST),
      step: range(STEP),
    },
  );
}

const read = (bytes = file()) => readTexture(new TensorFile(bytes), bytes, NETWORKS);

/** The code of a texel, as Python's `textures.packing` unpacks it. */
function unpacked(texel: number[], channel: number): number[] {
  const fine = 256 * texel[1 + 2 * channel] + texel[2 + 2 * channel];
  return [-1 + 0.001 * fine, 0.25 + 0.5 * texel[0], 3];
}

test("shader code makes a texel's codes of its bytes", () => {
  const texture = read();
  const names = ["red", "green", "blue"].map((c) => [0, 1, 2].map((i) => `code_${i}_${c}`));
  const text = texelShaderText(JSON.stringify(names).replaceAll('"', ""), texture);
  const texel = TEXELS.slice(8, 16);
  const stored = texel.map((byte) => byte / 255);
  const codes = new Function("stored", `return ${text};`)(stored) as number[][];
  codes.forEach((code, channel) => {
    code.forEach((number, k) => {
      expect(number).toBeCloseTo(unpacked(texel, channel)[k], 4);
    });
  });
});

test("the mean code is that of all texels", () => {
  const codes = meanCodes(read());
  for (const channel of [0, 1, 2])
    for (const k of [0, 1, 2]) {
      const [a, b] = [0, 8].map((at) => unpacked(TEXELS.slice(at, at + 8), channel)[k]);
      expect(codes[3 * channel + k]).toBeCloseTo((a! + b!) / 2, 4);
    }
});

test("size, place and name are read", () => {
  const texture = read();
  expect(texture.size).toEqual([2, 1]);
  expect(texture.toTexture).toEqual([0.5, 0, 0, 1, 0.1, 0]);
  expect(texture.id).toMatch(/^[0-9a-f]{8}$/);
  expect(isTexture(new TensorFile(file()))).toBe(true);
  expect(isTexture(new TensorFile(file({ kind: "material" })))).toBe(false);
});

const WHOLE = file();

test.each([
  ["nothing", new Uint8Array(0)],
  ["another version", file({ version: 2 })],
  ["other networks", file({ weights: "00c0ffee" })],
  ["a texel too few", file({ width: 3 })],
  ["two channels", file({ layout: { ...LAYOUT, channels: 2 } })],
  ["no layout", file({ layout: null })],
  ["no size", file({ width: -2, height: -1 })],
  ["a number too few", file({ layout: { ...LAYOUT, same: [false, true] } })],
  ["bytes beyond the texel", file({ layout: { ...LAYOUT, high: [0, 1, -1] } })],
  ["more bytes than a texel has", file({ layout: { ...LAYOUT, texel_bytes: 4 } })],
  ["no place", file({ place: {} })],
  ["half a place", file({ place: { ...DESCRIPTION.place, to_texture: [[1, 0, 0]] } })],
  ["an unknown wrap", file({ place: { ...DESCRIPTION.place, wrap: "none" } })],
  ["a part of a file", WHOLE.slice(0, WHOLE.length - 1)],
] as [string, Uint8Array<ArrayBuffer>][])("%s: refused", (_name, bytes) => {
  expect(() => read(bytes)).toThrow(Refusal);
});
