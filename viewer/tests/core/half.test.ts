/** Weights of half precision, by which the page loads in half the time. */

import { existsSync } from "node:fs";
import { expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { bytesOf, goldenFile, readVectors, SHIPPED } from "./vectors";

const files = { random: goldenFile("random.safetensors"), default: SHIPPED };

const available = (["random", "default"] as const).flatMap((name) => {
  const vectors = readVectors(name);
  return vectors && existsSync(files[name]) ? [[name, vectors] as const] : [];
});

test.each(available)("of %s networks hardly change f", { timeout: 30_000 }, (name, vectors) => {
  const whole = bytesOf(files[name]);
  const halved = halfPrecision(whole);
  expect(halved.byteLength).toBeLessThan(0.6 * whole.byteLength);
  const [wi, wo] = [vectors.of("wi"), vectors.of("wo")];
  const [exact, rounded] = [loadCore(whole), loadCore(halved)];
  const errors = vectors.stacks.flatMap((stack) => {
    const f = exact.f(exact.layer(stack), wi, wo);
    const near = rounded.f(rounded.layer(stack), wi, wo);
    return [...f].map((value, i) => Math.abs((near[i] as number) / value - 1));
  });
  const known = errors.filter(Number.isFinite).sort((a, b) => a - b);
  // A number has eleven digits; errors of thousands of weights average out.
  expect(known[Math.floor(known.length / 2)]).toBeLessThan(2 ** -9);
  expect(known[Math.floor(0.99 * known.length)]).toBeLessThan(0.05);
});

/** The file with its arrays in half precision. */
function halfPrecision(file: ArrayBuffer): ArrayBuffer {
  const view = new DataView(file);
  const length = Number(view.getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 8, length)));
  const parts: Uint16Array[] = [];
  let at = 0;
  for (const [name, entry] of Object.entries<{ data_offsets: [number, number] }>(header)) {
    if (name === "__metadata__") {
      continue;
    }
    const [start, end] = entry.data_offsets;
    const numbers = new Float32Array(file.slice(8 + length + start, 8 + length + end));
    parts.push(Uint16Array.from(numbers, halfBits));
    header[name] = { ...entry, dtype: "F16", data_offsets: [at, at + 2 * numbers.length] };
    at += 2 * numbers.length;
  }
  const text = new TextEncoder().encode(JSON.stringify(header));
  const size = new DataView(new ArrayBuffer(8));
  size.setBigUint64(0, BigInt(text.length), true);
  const bytes = [new Uint8Array(size.buffer), text, ...parts.map((part) => bytesIn(part))];
  return Uint8Array.from(bytes.flatMap((part) => [...part])).buffer;
}

function bytesIn(array: Uint16Array): Uint8Array {
  return new Uint8Array(array.buffer, array.byteOffset, array.byteLength);
}

/** The nearest number of half precision (IEEE 754). */
function halfBits(value: number): number {
  const size = Math.abs(value);
  const exponent = Math.max(Math.floor(Math.log2(size || 2 ** -14)), -14);
  const fraction = Math.round(size / 2 ** (exponent - 10)); // 1024 is the leading bit
  return (value < 0 ? 0x8000 : 0) + ((exponent + 14) << 10) + fraction;
}
