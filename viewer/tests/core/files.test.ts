/** Weights files: half precision, and damaged ones. */

import { describe, expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { FileError, readTensors } from "../../src/core/safetensors";
import { bytesOf, SHIPPED } from "./vectors";

/** A safetensors file of bytes and a header. */
function fileOf(header: object, bytes: Uint8Array): ArrayBuffer {
  const text = new TextEncoder().encode(JSON.stringify(header));
  const file = new Uint8Array(8 + text.length + bytes.length);
  new DataView(file.buffer).setBigUint64(0, BigInt(text.length), true);
  file.set(text, 8);
  file.set(bytes, 8 + text.length);
  return file.buffer;
}

function halves(bits: readonly number[]): ArrayBuffer {
  const bytes = new Uint8Array(Uint16Array.from(bits).buffer);
  const entry = { dtype: "F16", shape: [bits.length], data_offsets: [0, bytes.length] };
  return fileOf({ x: entry }, bytes);
}

test("numbers of half precision are read exactly", () => {
  // one, minus two, the largest, the smallest normal and subnormal number, minus zero
  const file = halves([0x3c00, 0xc000, 0x7bff, 0x0400, 0x0001, 0x8000]);
  const { values } = readTensors(file).tensors.get("x") ?? { values: [] };
  expect([...values]).toEqual([1, -2, 65504, 2 ** -14, 2 ** -24, -0]);
});

describe("refuses in a sentence", () => {
  const whole = bytesOf(SHIPPED);

  test.each([
    ["an empty file", new ArrayBuffer(0), /is no safetensors file, or truncated/],
    ["a truncated file", whole.slice(0, whole.byteLength - 10), /does not fit the file/],
    ["a truncated header", whole.slice(0, 100), /is no safetensors file, or truncated/],
    ["a header that is no JSON", fileOfText("{nonsense"), /is no safetensors file/],
    [
      "integers",
      fileOf({ x: { dtype: "I8", shape: [1], data_offsets: [0, 1] } }, new Uint8Array(1)),
      /of type I8/,
    ],
    [
      "a place outside of the file",
      fileOf({ x: { dtype: "F32", shape: [9], data_offsets: [0, 36] } }, new Uint8Array(4)),
      /does not fit/,
    ],
    ["a file of another kind", halves([0]), /no weights of Urushi's networks/],
  ])("%s", (_, file, sentence) => {
    expect(() => loadCore(file)).toThrow(FileError);
    expect(() => loadCore(file)).toThrow(sentence);
  });

  test("networks without a parameter", () => {
    expect(() => loadCore(renamed(whole, "proposal.bias", "proposal.gone"))).toThrow(
      /'proposal.bias' is missing/,
    );
  });

  test("an activation that it does not know", () => {
    expect(() => loadCore(renamed(whole, "silu7", "siren"))).toThrow(/'siren' is unknown/);
  });
});

function fileOfText(text: string): ArrayBuffer {
  const bytes = new TextEncoder().encode(text);
  const file = new Uint8Array(8 + bytes.length);
  file[0] = bytes.length;
  file.set(bytes, 8);
  return file.buffer;
}

/** The file with a text of its header replaced by one of the same length. */
function renamed(file: ArrayBuffer, from: string, to: string): ArrayBuffer {
  const copy = file.slice(0);
  const bytes = new Uint8Array(copy);
  const latin = new TextDecoder("latin1").decode(bytes);
  bytes.set(new TextEncoder().encode(to), latin.indexOf(from));
  return copy;
}
