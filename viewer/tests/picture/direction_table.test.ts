import { expect, test } from "vitest";
import { directionTexels } from "../../src/picture/direction_table";

test("a table's rows become columns, its directions half vectors", () => {
  const sizes = { azimuths: 1, cosines: 4, samples: 2 };
  const table = new Float32Array(8 * 4 * 2);
  const wo = [0.6, -0.48, 0.64];
  table.set([...wo, 41, 42, 43, 8], 8 * (2 * 2 + 1)); // cosine 5/8, the second sample
  const texels = directionTexels(table, sizes, false);
  const column = (row: number) => texels.subarray(4 * (4 * row + 2), 4 * (4 * row + 2) + 4);
  const half = column(2);
  const wi = [Math.sqrt(1 - (5 / 8) ** 2), 0, 5 / 8];
  const along = 2 * wi.reduce((sum, part, k) => sum + part * half[k], 0);
  wo.forEach((part, k) => {
    expect(along * half[k] - wi[k]).toBeCloseTo(part, 5);
  });
  expect(half[3]).toBe(3);
  // The weights have lost those of the diffuse part; the mean of all is the albedo.
  [41, 42, 43].forEach((weight, k) => {
    expect(column(5)[k]).toBeCloseTo(weight / 2, 4);
    expect(column(3)[k] + (column(4)[k] * wo[2]) / (8 * Math.PI)).toBeCloseTo(weight, 4);
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
