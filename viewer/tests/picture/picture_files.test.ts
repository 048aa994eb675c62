import { readFileSync } from "node:fs";
import { join } from "node:path";
import { describe, expect, test } from "vitest";
import { FileError } from "../../src/core/safetensors";
import { readPanorama, readPicture } from "../../src/picture/picture_files";
import { exrFile } from "../../src/save/exr";
import { folderOfTest, hasPython, python } from "../python";

/** Writes pictures that Mitsuba compresses, in single and in half precision, and prints the pixels. */
const WRITE = `
import json, sys
import mitsuba as mi
import numpy as np
mi.set_variant("scalar_rgb")
pixels = 100 * np.random.default_rng(1).random((32, 64, 3), dtype=np.float32) ** 4
mi.Bitmap(pixels).write(sys.argv[1] + "/single.exr")
half = mi.Bitmap(pixels).convert(component_format=mi.Struct.Type.Float16)
half.write(sys.argv[1] + "/half.exr")
print(json.dumps(pixels.ravel().tolist()))
`;

describe("reading .exr files", () => {
  const pixels = Float32Array.from({ length: 3 * 8 * 4 }, (_, at) => 1.5 ** (at / 4) - 1);

  test("what the page writes is read", () => {
    const panorama = { width: 8, height: 4, pixels };
    expect(readPicture(exrFile(panorama), "exr")).toEqual(panorama);
  });

  test.skipIf(!hasPython)("what Mitsuba writes is read", () => {
    const folder = folderOfTest();
    const written: number[] = JSON.parse(python(WRITE, folder));
    const read = (name: string) => readPicture(readFileSync(join(folder, name)), "exr");
    const single = read("single.exr");
    expect([single.width, single.height]).toEqual([64, 32]);
    expect([...single.pixels]).toEqual(written);
    read("half.exr").pixels.forEach((value, at) => {
      // Eleven bits, or steps of 2^-24
      expect(Math.abs(value - written[at])).toBeLessThan(2 ** -11 * written[at] + 2 ** -24);
    });
  });

  test("a file that ends early and another file are refused", () => {
    const file = exrFile({ width: 8, height: 4, pixels });
    for (let length = 0; length < file.length - 1; length += 7)
      expect(() => readPicture(file.subarray(0, length), "exr"), `${length}`).toThrow(FileError);
  });
});

function hdr(width: number, height: number, body: number[]): Uint8Array {
  const header = `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`;
  return new Uint8Array([...new TextEncoder().encode(header), ...body]);
}

/** A row of eight pixels in runs: red, green and blue 128, 64, 32, exponent 129. */
const RUNS = [2, 2, 0, 8, 136, 128, 136, 64, 132, 32, 132, 32, 8, ...Array(8).fill(129)];

test("plain and run-length coded .hdr files are equal", () => {
  const plain = readPicture(hdr(8, 4, Array(32).fill([128, 64, 32, 129]).flat()), "hdr");
  expect(plain).toEqual(readPicture(hdr(8, 4, Array(4).fill(RUNS).flat()), "hdr"));
  [1, 0.5, 0.25].forEach((value, k) => {
    expect(plain.pixels[k]).toBeCloseTo(value, 6);
  });
});

test("a run-length coded .hdr file that ends early is refused, and one with more at its end is read", () => {
  const band = [8, ...Array(8).fill(128)];
  const literal = [2, 2, 0, 8, ...band, ...band, ...band, ...band];
  for (const row of [RUNS, literal]) {
    const rows = Array(4).fill(row).flat();
    const whole = readPicture(hdr(8, 4, rows), "hdr");
    expect(readPicture(hdr(8, 4, [...rows, 10, 10]), "hdr")).toEqual(whole);
    for (let length = 0; length < rows.length; length++)
      expect(() => readPicture(hdr(8, 4, rows.slice(0, length)), "hdr")).toThrow(FileError);
  }
});

test.each([
  ["another file", "hdr", new TextEncoder().encode("P6 4 2 255")],
  ["another file", "exr", new TextEncoder().encode("P6 4 2 255")],
  ["a square picture", "hdr", hdr(8, 8, Array(256).fill(0))],
  ["a huge picture", "hdr", hdr(100_000, 50_000, [])],
  ["an incomplete file", "hdr", hdr(8, 4, Array(100).fill(64))],
] as const)("%s (%s) is refused", (_name, suffix, bytes) => {
  expect(() => readPanorama(bytes, suffix)).toThrow(FileError);
});
