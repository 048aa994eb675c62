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

test("the shader finds each pair at its place", () => {
  const { wi, wo } = brightPairs(COARSE);
  let checked = 0;
  let farthest = 0; // in steps of the table
  for (let k = 0; k < COARSE.slants; k++)
    for (let j = 1; j < COARSE.differences - 1; j++)
      for (let i = 8; i < COARSE.halves; i += 3) {
        const at = 3 * ((k * COARSE.differences + j) * COARSE.halves + i);
        const [a, b] = [wi.subarray(at, at + 3), wo.subarray(at, at + 3)];
        if (Math.min(a[2]!, b[2]!) < 0.02) continue; // lifted above the horizon
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

test("a table's rows become columns", () => {
  const [cosines, samples] = [3, 2];
  const table = Float32Array.from({ length: 8 * cosines * samples }, (_, at) => at + 1);
  const texels = directionTexels(table, cosines, samples);
  // Row 2, sample 1 begins at 40 in the table; its weight is one row of texels below.
  const at = 4 * (2 * 1 * cosines + 2);
  expect([...texels.subarray(at, at + 3)]).toEqual([41, 42, 43]);
  expect(texels[at + 3]).toBeCloseTo(Math.log2(47), 5);
  expect([...texels.subarray(at + 4 * cosines, at + 4 * cosines + 3)]).toEqual([44, 45, 46]);
});
