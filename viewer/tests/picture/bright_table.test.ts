import { expect, test } from "vitest";
import {
  brightPairs,
  brightTexels,
  COARSE,
  directionTexels,
  FAR,
  NEAR,
} from "../../src/picture/bright_table";

/** Where the shader looks for a pair, in steps of the table. */
function placeOf(wi: Float32Array, wo: Float32Array): number[] {
  const half = [0, 1, 2].map((k) => wi[k]! + wo[k]!);
  const length = Math.hypot(...half);
  const cosDifference = Math.min(length / 2, 1);
  const cosHalf = half[2]! / length;
  const sinHalf = Math.sqrt(Math.max(1 - cosHalf ** 2, 0));
  const sinDifference = Math.sqrt(1 - cosDifference ** 2);
  return [
    (Math.log2(1 + sinHalf / cosHalf / NEAR) / Math.log2(1 + FAR / NEAR)) * (COARSE.halves - 1),
    (Math.acos(cosDifference) / (Math.PI / 2)) * (COARSE.differences - 1),
    (Math.abs(wi[2]! - wo[2]!) / (2 * sinHalf * sinDifference + 1e-6)) * (COARSE.slants - 1),
  ];
}

/** The lower direction's cosine at a place of the table. */
function lowest(i: number, j: number, k: number): number {
  const half = Math.atan(NEAR * ((1 + FAR / NEAR) ** (i / (COARSE.halves - 1)) - 1));
  const difference = (Math.PI / 2) * (j / (COARSE.differences - 1));
  const along = (k / (COARSE.slants - 1)) * Math.sin(difference);
  return Math.cos(half) * Math.cos(difference) - Math.sin(half) * along;
}

test("the shader finds each pair at its place", () => {
  const { wi, wo } = brightPairs(COARSE);
  let checked = 0;
  let farthest = 0; // in steps of the table
  for (let k = 0; k < COARSE.slants; k++)
    for (let j = 1; j < COARSE.differences - 1; j++)
      for (let i = 8; i < COARSE.halves; i += 3) {
        if (lowest(i, j, k) < 0.02) continue; // lifted above the horizon
        const at = 3 * ((k * COARSE.differences + j) * COARSE.halves + i);
        const [a, b] = [wi.subarray(at, at + 3), wo.subarray(at, at + 3)];
        const place = placeOf(a, b);
        farthest = Math.max(farthest, ...[i, j, k].map((x, axis) => Math.abs(place[axis]! - x)));
        checked++;
      }
  expect(checked).toBeGreaterThan(300);
  expect(farthest).toBeLessThan(0.05);
});

test("all directions are unit vectors above the horizon", () => {
  const { wi, wo } = brightPairs(COARSE);
  const lengths: number[] = [];
  const heights: number[] = [];
  for (const vectors of [wi, wo])
    for (let at = 0; at < vectors.length; at += 3) {
      lengths.push(Math.hypot(...vectors.subarray(at, at + 3)));
      heights.push(vectors[at + 2]!);
    }
  expect(Math.min(...lengths)).toBeCloseTo(1, 5);
  expect(Math.max(...lengths)).toBeCloseTo(1, 5);
  expect(Math.min(...heights)).toBeGreaterThan(0.01);
});

test("texels hold the logarithm, and black is finite", () => {
  const texels = brightTexels(new Float32Array([Math.E, 1, 0]));
  expect(texels[0]).toBeCloseTo(1, 6);
  expect(texels[1]).toBe(0);
  expect(Number.isFinite(texels[2]!)).toBe(true);
});

test("a table's rows become columns, its directions half vectors", () => {
  const sizes = { azimuths: 1, cosines: 4, samples: 2 };
  const table = new Float32Array(8 * 4 * 2);
  const wo = [0.6, -0.48, 0.64];
  table.set([...wo, 41, 42, 43, 8], 8 * (2 * 2 + 1)); // cosine 5/8, the second sample
  const texels = directionTexels(table, sizes, false);
  const column = (row: number) => texels.subarray(4 * (4 * row + 2), 4 * (4 * row + 2) + 4);
  const half = column(2);
  const wi = [Math.sqrt(1 - (5 / 8) ** 2), 0, 5 / 8];
  const along = 2 * wi.reduce((sum, part, k) => sum + part * half[k]!, 0);
  wo.forEach((part, k) => {
    expect(along * half[k]! - wi[k]!).toBeCloseTo(part, 5);
  });
  expect(half[3]).toBe(3);
  // The weights have lost those of the diffuse part; the mean of all is the albedo.
  [41, 42, 43].forEach((weight, k) => {
    expect(column(5)[k]).toBeCloseTo(weight / 2, 4);
    expect(column(3)[k]! + (column(4)[k]! * wo[2]!) / (8 * Math.PI)).toBeCloseTo(weight, 4);
  });
});

test("all of a diffuse reflector is its diffuse part, whatever its directions are drawn by", () => {
  const sizes = { azimuths: 1, cosines: 8, samples: 16 };
  const albedo = [0.2, 0.5, 0.8];
  const table = new Float32Array(8 * 8 * 16);
  for (let at = 0; at < table.length; at += 8) {
    const [cosine, density] = [((at / 8) % 16) / 16 + 1 / 32, 0.1 + ((7 * at) % 64) / 64];
    const weight = cosine / (Math.PI * density);
    const wo = [Math.sqrt(1 - cosine ** 2), 0, cosine];
    table.set([...wo, ...albedo.map((rho) => rho * weight), density], at);
  }
  const texels = directionTexels(table, sizes, false);
  for (let row = 0; row < 16; row++)
    for (const weight of texels.subarray(32 * (2 * row + 1), 32 * (2 * row + 2)))
      expect(weight).toBeCloseTo(0, 5);
  for (let column = 0; column < 8; column++)
    albedo.forEach((rho, k) => {
      expect(texels[32 * 32 + 4 * column + k]).toBeCloseTo(rho, 5);
    });
});
