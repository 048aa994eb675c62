/**
 * The random walk against values of independent simulators, and against laws.
 *
 * The bounds are those of Python's tests of its own walk (`tests/walk/test_oracle.py`).
 */

import { describe, expect, test } from "vitest";
import type { Stack } from "../../src/core/api";
import { readTensors } from "../../src/core/safetensors";
import { uniformNumbers } from "../../src/core/walk/random";
import { type Estimate, Reference } from "../../src/core/walk/reference";
import { bytesOf, goldenFile } from "./vectors";

const file = readTensors(bytesOf(goldenFile("reference_values.safetensors")));
const stacks = file.description.stacks as Stack[];

/** An array of one stack. */
function of(name: string, stack: number): Float32Array {
  const values = file.tensors.get(name)?.values ?? new Float64Array();
  const size = values.length / stacks.length;
  return Float32Array.from(values.subarray(stack * size, (stack + 1) * size));
}

function estimated(stack: Stack, wi: Float32Array, wo: Float32Array, walks: number): Estimate {
  const reference = new Reference(stack, wi, wo, 1);
  reference.add(walks);
  return reference.estimate();
}

describe("values of independent simulators", () => {
  const WALKS = 1024;
  const deviations = stacks.map((stack, place) => {
    const { f, error } = estimated(stack, of("wi", place), of("wo", place), WALKS);
    const [expected, se] = [of("f", place), of("se", place)];
    return Array.from(expected, (value, i) => {
      const mean = f[3 * i] as number;
      // Rounded parameters on both sides: a difference of 0.2 % of f is allowed.
      const variance = (error[3 * i] as number) ** 2 + (se[i] as number) ** 2 + (0.002 * mean) ** 2;
      return { difference: mean - value, mean, variance };
    });
  });

  test("deviations agree with the standard errors", () => {
    const squares = deviations.flat().map(({ difference, variance }) => difference ** 2 / variance);
    const mean = squares.reduce((a, b) => a + b, 0) / squares.length;
    expect(mean).toBeLessThan(1.4);
    expect(mean).toBeGreaterThan(0.5); // else the standard errors are too large
  });

  test("the mean ratio of all values is one", () => {
    // Weighted by precision, 456 values of 1 to 2 % each determine it to 0.1 %.
    let [sum, weight] = [0, 0];
    for (const { difference, mean, variance } of deviations.flat()) {
      sum += (difference / mean) * (mean ** 2 / variance);
      weight += mean ** 2 / variance;
    }
    expect(Math.abs(sum / weight)).toBeLessThan(0.004);
  });

  test.each(deviations.map((values, place) => [place, values] as const))(
    "stack %i agrees",
    (_, values) => {
      const squares = values.map(({ difference, variance }) => difference ** 2 / variance);
      const mean = squares.reduce((a, b) => a + b, 0) / squares.length;
      // Four standard deviations of a mean of squares, doubled for the long tails of walks.
      expect(mean).toBeLessThan(1 + 8 * Math.sqrt(2 / values.length));
    },
  );
});

describe("laws", () => {
  const [wi, wo] = [of("wi", 13), of("wo", 13)];

  test("f is reciprocal within its errors", () => {
    const stack = stacks[13] as Stack;
    const there = estimated(stack, wi, wo, 256);
    const back = estimated(stack, wo, wi, 256);
    const squares = Array.from(
      there.f,
      (value, i) => (value - back.f[i]) ** 2 / (there.error[i] ** 2 + back.error[i] ** 2),
    );
    expect(squares.reduce((a, b) => a + b, 0) / squares.length).toBeLessThan(1.6);
  });

  test("the same seed gives the same numbers, however they are asked for", () => {
    const stack = stacks[0] as Stack;
    const [whole, parts] = [5, 5].map((seed) => new Reference(stack, wi, wo, seed));
    whole?.add(1);
    whole?.add(1);
    parts?.add(1);
    parts?.estimate();
    parts?.add(1);
    expect(parts?.estimate()).toEqual(whole?.estimate());
  });

  test("channels of equal parameters have equal values, others their own", () => {
    const coat = { alpha: 0.2, eta: 1.5, albedo: [0.9, 0.9, 0.1], sigmaT: 1, g: 0 } as const;
    const stack: Stack = { bottom: { kind: "diffuse", reflectance: 0.5 }, coats: [coat] };
    const { f } = estimated(stack, wi, wo, 64);
    for (let i = 0; i < f.length; i += 3) {
      expect(f[i + 1]).toBe(f[i]);
    }
    const [bright, dark] = [0, 2].map((k) => f.filter((_, i) => i % 3 === k));
    const total = (values = new Float32Array()) => values.reduce((a, b) => a + b, 0);
    expect(total(dark)).toBeLessThan(0.9 * total(bright));
  });

  test("an absorbing medium without an interface is Beer's law over a diffuse surface", () => {
    const coat = { alpha: 0.5, eta: 1, albedo: 0, sigmaT: 0.4, g: 0 } as const;
    const bottom = { kind: "diffuse", reflectance: 0.6 } as const;
    for (const coats of [[coat], [coat, { ...coat, sigmaT: 0.3 }]]) {
      const depth = coats.reduce((sum, { sigmaT }) => sum + sigmaT, 0);
      const { f, error } = estimated({ bottom, coats }, wi, wo, 512);
      const squares = Array.from({ length: wi.length / 3 }, (_, i) => {
        const slant = 1 / (wi[3 * i + 2] as number) + 1 / (wo[3 * i + 2] as number);
        const expected = (0.6 / Math.PI) * Math.exp(-depth * slant);
        return ((f[3 * i] as number) - expected) ** 2 / ((error[3 * i] as number) ** 2 + 1e-12);
      });
      const mean = squares.reduce((a, b) => a + b, 0) / squares.length;
      expect(mean).toBeLessThan(1 + 8 * Math.sqrt(2 / squares.length)); // as above
    }
  });

  test("a medium in two parts of equal index is the medium", () => {
    const coat = { alpha: 0.2, eta: 1.5, albedo: 0.8, sigmaT: 1, g: 0.3 } as const;
    const bottom = { kind: "conductor", alpha: 0.3, r0: 0.9 } as const;
    const parts = [
      { ...coat, sigmaT: 0.6 },
      { ...coat, alpha: 0.7, eta: 1, sigmaT: 0.4 },
    ];
    const whole = estimated({ bottom, coats: [coat] }, wi, wo, 512);
    const divided = estimated({ bottom, coats: parts }, wi, wo, 512);
    const squares = Array.from(whole.f, (value, i) => {
      const variance = (whole.error[i] as number) ** 2 + (divided.error[i] as number) ** 2;
      return (value - (divided.f[i] as number)) ** 2 / variance;
    }).filter((_, i) => i % 3 === 0);
    const mean = squares.reduce((a, b) => a + b, 0) / squares.length;
    expect(mean).toBeLessThan(1 + 8 * Math.sqrt(2 / squares.length));
  });

  test("a bare surface is exact", () => {
    const stack: Stack = { bottom: { kind: "diffuse", reflectance: 0.6 }, coats: [] };
    const { f, error } = estimated(stack, wi, wo, 2);
    expect(Math.max(...error)).toBe(0);
    for (const value of f) {
      expect(value).toBeCloseTo(0.6 / Math.PI, 6);
    }
  });

  test("a loaded material is refused in a sentence", () => {
    const codes = new Float32Array(72);
    const stack: Stack = { bottom: { kind: "codes", latents: codes }, coats: [] };
    expect(() => new Reference(stack, wi, wo, 0)).toThrow(/a loaded material has no reference/);
  });
});

test("uniform numbers are spread evenly and independent", () => {
  const uniform = uniformNumbers(3);
  const counts = new Float64Array(256);
  const draws = 1 << 16;
  for (let i = 0; i < draws; i++) {
    const [x, y] = [uniform(), uniform()];
    counts[Math.floor(16 * x) * 16 + Math.floor(16 * y)]++;
  }
  const expected = draws / counts.length;
  const chi2 = counts.reduce((sum, count) => sum + (count - expected) ** 2 / expected, 0);
  // 255 degrees of freedom: mean 255, deviation 22.6; five deviations
  expect(Math.abs(chi2 - 255)).toBeLessThan(113);
});
