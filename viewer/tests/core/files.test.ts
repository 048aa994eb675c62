/** Files of arrays and weights: half precision, and damaged ones. */

import { describe, expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { FileError, TensorFile, tensorFile } from "../../src/core/safetensors";
import { bytesOf, SHIPPED } from "./vectors";

function halves(bits: readonly number[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(Uint16Array.from(bits).buffer);
  return tensorFile({}, { x: { dtype: "F16", shape: [bits.length], bytes } });
}

test("numbers of half precision are read exactly", () => {
  // one, minus two, the largest, the smallest normal and subnormal number, minus zero
  const file = new TensorFile(halves([0x3c00, 0xc000, 0x7bff, 0x0400, 0x0001, 0x8000]));
  const expected = [1, -2, 65504, 2 ** -14, 2 ** -24, -0];
  expect([...file.numbers("x", [6])]).toEqual(expected);
});

describe("refuses in a sentence", () => {
  const whole = bytesOf(SHIPPED);

  test.each([
    ["an empty file", new ArrayBuffer(0), /is no safetensors file, or truncated/],
    ["a truncated file", whole.slice(0, whole.byteLength - 10), /does not fit the file/],
    ["a truncated header", whole.slice(0, 100), /is no safetensors file, or truncated/],
    ["a file of another kind", halves([0]).buffer, /no weights of Urushi's networks/],
    ["networks without a parameter", renamed("proposal.bias", "proposal.gone"), /is missing/],
    ["an activation that it does not know", renamed("silu7", "siren"), /'siren' is unknown/],
  ])("%s", (_, file, sentence) => {
    expect(() => loadCore(file)).toThrow(FileError);
    expect(() => loadCore(file)).toThrow(sentence);
  });

  test("codes of other networks", () => {
    const bottom = { kind: "codes", latents: new Float32Array(3) } as const;
    const core = loadCore(whole);
    expect(() => core.layer({ bottom, coats: [] })).toThrow(FileError);
    expect(() => core.layer({ bottom, coats: [] })).toThrow(/of other networks \(3 numbers/);
  });

  test("arrays of another shape or type, and numbers that are not finite", () => {
    const file = new TensorFile(halves([0x7c00]));
    expect(() => file.numbers("x", [2])).toThrow(/has the shape \(1\)/);
    expect(() => file.bytes("x", "F32", [1])).toThrow(/type F16; this page needs \(1\) and F32/);
    expect(() => file.numbers("x", [1])).toThrow(/not finite/);
  });
});

/** The shipped weights with a text of the header replaced by one of the same length. */
function renamed(from: string, to: string): ArrayBuffer {
  const copy = bytesOf(SHIPPED);
  const bytes = new Uint8Array(copy);
  const latin = new TextDecoder("latin1").decode(bytes);
  bytes.set(new TextEncoder().encode(to), latin.indexOf(from));
  return copy;
}
