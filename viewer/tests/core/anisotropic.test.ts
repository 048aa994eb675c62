/** Networks of two GGX widths: symmetries, and tables at azimuths of the view. */

import { expect, test } from "vitest";
import type { Stack } from "../../src/core/api";
import { loadCore } from "../../src/core/core";
import { bytesOf, relativeError, SHIPPED_ANISOTROPIC } from "./vectors";

const core = loadCore(bytesOf(SHIPPED_ANISOTROPIC));

const BRUSHED: Stack = {
  bottom: { kind: "conductor", alpha: 0.3, alphaV: 0.1, r0: [0.9, 0.7, 0.5] },
  coats: [{ alpha: 0.2, eta: 1.5, albedo: 0.3, sigmaT: 0.2, g: 0 }],
};

/** Unit vectors (N, 3) above the horizon by golden angles. */
function directions(count: number, turn: number): Float32Array {
  const numbers = Array.from({ length: count }, (_, i) => {
    const z = (i + 0.5) / count;
    const r = Math.sqrt(1 - z * z);
    return [r * Math.cos(turn * i), r * Math.sin(turn * i), z];
  });
  return Float32Array.from(numbers.flat());
}

const mirrored = (w: Float32Array, signs: readonly number[]) => w.map((x, i) => x * signs[i % 3]);

test("f is the same with exchanged directions and for mirror images", () => {
  const material = core.layer(BRUSHED);
  const [wi, wo] = [directions(200, 2.4), directions(200, 1.1).reverse()];
  for (let i = 0; i < wo.length; i += 3) wo.subarray(i, i + 3).reverse();
  const f = core.f(material, wi, wo);
  expect(core.f(material, wo, wi)).toEqual(f);
  for (const signs of [
    [1, -1, 1],
    [-1, 1, 1],
    [-1, -1, 1],
  ])
    expect(core.f(material, mirrored(wi, signs), mirrored(wo, signs))).toEqual(f);
});

test("the rows of a table have the directions, densities and f of their azimuths", () => {
  const material = core.layer(BRUSHED);
  const [azimuths, cosines, samples] = [3, 4, 32];
  const table = core.table(material, { azimuths, cosines, samples, shift: [0.1, 0.2, 0.3] });
  for (let row = 0; row < azimuths * cosines; row++) {
    const cosine = ((row % cosines) + 0.5) / cosines;
    const sine = Math.sqrt(1 - cosine * cosine);
    const azimuth = (0.25 * Math.PI * Math.floor(row / cosines)) as number;
    const one = [sine * Math.cos(azimuth), sine * Math.sin(azimuth), cosine];
    const rows = Array.from({ length: samples }, (_, i) => 8 * (row * samples + i));
    const wi = Float32Array.from(rows.flatMap(() => one));
    const wo = Float32Array.from(rows.flatMap((at) => [...table.subarray(at, at + 3)]));
    const f = core.f(material, wi, wo);
    const pdf = rows.map((at) => table[at + 6]);
    const weights = rows.flatMap((at) => [...table.subarray(at + 3, at + 6)]);
    const expected = Array.from(f, (value, k) => {
      const i = Math.floor(k / 3);
      return (value * wo[3 * i + 2]) / pdf[i];
    });
    // Directions are rounded to single precision, which narrow lobes amplify.
    expect(relativeError(weights, expected, 1e-3)).toBeLessThan(1e-3);
  }
});
