import { expect, test } from "vitest";
import {
  ANISOTROPIC_COARSE,
  anisotropicPairs,
  brightTexels,
  FAR,
  NEAR,
} from "../../src/picture/anisotropic_table";

const { along, across, differences, turns } = ANISOTROPIC_COARSE;

/** Where the shader looks for a pair, in steps of the table. */
function placeOf(wi: Float32Array, wo: Float32Array): number[] {
  const sum = [0, 1, 2].map((k) => wi[k]! + wo[k]!);
  const size = Math.hypot(...sum);
  const half = sum.map((x) => x / size);
  const difference = [0, 1, 2].map((k) => wi[k]! - wo[k]!);
  const share = difference[2]! / (1 + half[2]!);
  const flat = [difference[0]! - share * half[0]!, difference[1]! - share * half[1]!];
  const slope = (x: number) => Math.log2(1 + x / (half[2]! * NEAR)) / Math.log2(1 + FAR / NEAR);
  const turn = Math.atan2(flat[1]!, flat[0]!) / Math.PI;
  return [
    slope(half[0]!) * (along - 1),
    slope(half[1]!) * (across - 1),
    Math.atan2(Math.hypot(...flat), size) * (2 / Math.PI) * (differences - 1),
    (turn - Math.floor(turn)) * turns,
  ];
}

test("the shader finds each pair at its place", () => {
  const { wi, wo } = anisotropicPairs(ANISOTROPIC_COARSE);
  let checked = 0;
  let farthest = 0; // in steps of the table
  for (let turn = 0; turn < turns; turn++)
    for (let step = 1; step < differences - 1; step++)
      for (let j = 4; j < across; j++)
        for (let i = 4; i < along; i++) {
          const at = 3 * (((turn * differences + step) * across + j) * along + i);
          const [a, b] = [wi.subarray(at, at + 3), wo.subarray(at, at + 3)];
          if (Math.min(a[2]!, b[2]!) < 0.05) continue; // it may be lifted above the horizon
          const place = placeOf(a, b);
          const away = [i, j, step, turn].map((x, axis) => Math.abs(place[axis]! - x));
          away[3] = Math.min(away[3]!, turns - away[3]!);
          farthest = Math.max(farthest, ...away);
          checked++;
        }
  expect(checked).toBeGreaterThan(1000);
  expect(farthest).toBeLessThan(0.05);
});

test("all directions are unit vectors above the horizon", () => {
  const lengths: number[] = [];
  const heights: number[] = [];
  for (const vectors of Object.values(anisotropicPairs(ANISOTROPIC_COARSE)))
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
