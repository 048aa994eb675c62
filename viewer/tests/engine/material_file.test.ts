import { expect, test } from "vitest";
import type { Networks } from "../../src/core/core";
import { TensorFile, tensorFile } from "../../src/core/safetensors";
import { materialFile, readMaterialFile } from "../../src/engine/material_file";
import { Refusal } from "../../src/refusal";

const NETWORKS = { latentSize: 2, widths: 1 as const, fingerprint: "8d3f00a1" };

/** A material file of an array of single precision. */
function file(
  latents: { shape: number[]; values: number[] } | null,
  kind = "material",
  weights = NETWORKS.fingerprint,
): Uint8Array<ArrayBuffer> {
  const { shape, values } = latents ?? SIX;
  const bytes = new Uint8Array(Float32Array.from(values).buffer);
  const array = { dtype: "F32", shape, bytes } as const;
  return tensorFile({ kind, weights }, latents ? { latents: array } : {});
}

const read = (bytes: Uint8Array, networks: Networks = NETWORKS) =>
  readMaterialFile(new TensorFile(bytes), networks);

const SIX = { shape: [3, 2], values: [1, 2, 3, 4, 5, 6] };

test("a grey material has three equal codes", () => {
  const { bottom } = read(file({ shape: [1, 2], values: [1, 2] }));
  expect(bottom).toMatchObject({ latents: new Float32Array([1, 2, 1, 2, 1, 2]) });
});

const WHOLE = file(SIX);

const BAD: [string, Uint8Array][] = [
  ["nothing", new Uint8Array(0)],
  ["text", new TextEncoder().encode("this is no such file at all")],
  ["weights", file(SIX, "weights")],
  ["no codes", file(null)],
  ["codes of other networks", file(SIX, "material", "00c0ffee")],
  ["codes of another size", file({ shape: [3, 1], values: [1, 2, 3] })],
  ["a number that is not finite", file({ ...SIX, values: [1, 2, 3, 4, 5, NaN] })],
  ...[4, 8, 40, WHOLE.length - 1].map((length): [string, Uint8Array] => [
    `${length} bytes of a file`,
    WHOLE.slice(0, length),
  ]),
];

test.each(BAD)("%s: refused", (_name, bytes) => {
  expect(() => read(bytes)).toThrow(Refusal);
});

test("what is written is read again", () => {
  const latents = new Float32Array([0.1, -2, 3e-7, 4, 5, 6]);
  const written = materialFile({ latents }, NETWORKS);
  expect(read(written).bottom).toEqual({ kind: "codes", latents });
  const two = { ...NETWORKS, widths: 2 } as const;
  expect(read(materialFile({ latents }, two, -35), two)).toEqual({
    bottom: { kind: "codes", latents, widths: 2 },
    rotation: -35,
  });
});
