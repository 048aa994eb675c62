import { expect, test } from "vitest";
import { materialFile, readMaterialFile } from "../../src/engine/material_file";
import { Refusal } from "../../src/refusal";

const NETWORKS = { latentSize: 2, widths: 1 as const, fingerprint: "8d3f00a1" };

/** A safetensors file of float32 arrays. */
function file(
  arrays: Record<string, { shape: number[]; values: number[] }>,
  kind = "material",
  weights = NETWORKS.fingerprint,
): Uint8Array {
  const header: Record<string, unknown> = {
    __metadata__: { urushi: JSON.stringify({ kind, version: 2, weights }) },
  };
  const all: number[] = [];
  for (const [name, { shape, values }] of Object.entries(arrays)) {
    const start = 4 * all.length;
    all.push(...values);
    header[name] = { dtype: "F32", shape, data_offsets: [start, 4 * all.length] };
  }
  const text = new TextEncoder().encode(JSON.stringify(header));
  const bytes = new Uint8Array(8 + text.length + 4 * all.length);
  new DataView(bytes.buffer).setUint32(0, text.length, true);
  bytes.set(text, 8);
  bytes.set(new Uint8Array(new Float32Array(all).buffer), 8 + text.length);
  return bytes;
}

const SIX = { shape: [3, 2], values: [1, 2, 3, 4, 5, 6] };

test("codes are read", () => {
  expect(readMaterialFile(file({ latents: SIX }), NETWORKS).bottom).toEqual({
    kind: "codes",
    latents: new Float32Array(SIX.values),
  });
});

test("a grey material has three equal codes", () => {
  const { bottom } = readMaterialFile(
    file({ latents: { shape: [1, 2], values: [1, 2] } }),
    NETWORKS,
  );
  expect(bottom).toMatchObject({ latents: new Float32Array([1, 2, 1, 2, 1, 2]) });
});

const WHOLE = file({ latents: SIX });

const BAD: [string, Uint8Array][] = [
  ["nothing", new Uint8Array(0)],
  ["text", new TextEncoder().encode("this is no such file at all")],
  ["weights", file({ latents: SIX }, "weights")],
  ["no codes", file({})],
  ["codes of other networks", file({ latents: SIX }, "material", "00c0ffee")],
  ["codes of another size", file({ latents: { shape: [3, 1], values: [1, 2, 3] } })],
  ["a number that is not finite", file({ latents: { ...SIX, values: [1, 2, 3, 4, 5, NaN] } })],
  ...[4, 8, 40, WHOLE.length - 1].map((length): [string, Uint8Array] => [
    `${length} bytes of a file`,
    WHOLE.slice(0, length),
  ]),
];

test.each(BAD)("%s: refused", (_name, bytes) => {
  expect(() => readMaterialFile(bytes, NETWORKS)).toThrow(Refusal);
});

test("what is written is read again", () => {
  const latents = new Float32Array([0.1, -2, 3e-7, 4, 5, 6]);
  const written = materialFile({ latents }, NETWORKS);
  expect(readMaterialFile(written, NETWORKS).bottom).toEqual({ kind: "codes", latents });
  const two = { ...NETWORKS, widths: 2 } as const;
  expect(readMaterialFile(materialFile({ latents }, two, -35), two)).toEqual({
    bottom: { kind: "codes", latents, widths: 2 },
    rotation: -35,
  });
});
