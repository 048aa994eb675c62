/**
 * The core against golden vectors of Python (`viewer/tests/golden.py`).
 *
 * Python's networks compute in double precision there, as the core does. Functions of a basis are of
 * single precision, which least squares amplify in the numbers of codes that hardly matter. Numbers
 * of codes, which may be near zero, are compared relative to 0.1.
 */

import { beforeAll, describe, expect, test } from "vitest";
import { loadCore, type NetworkCore } from "../../src/core/core";
import { bytesOf, readVectors, relativeError, SHIPPED, SHIPPED_ANISOTROPIC } from "./vectors";

const AGREEMENT = 2e-4;
const LEAST_CODE = 0.1;

/** Codes that the energy limit scales: the page measures albedos by other nodes than Python. */
const LIMITED = { default: 2e-3, anisotropic: 0.05 };

/** Albedos by other nodes. */
const ALBEDO = 1e-3;

/** Directions of sharp lobes amplify Python's rounding by a few units of 1 / alpha. */
const DENSITY_OF_DRAWN = 1e-4;

const files = {
  default: SHIPPED,
  anisotropic: SHIPPED_ANISOTROPIC,
};

describe.each(Object.keys(files) as (keyof typeof files)[])("%s networks", (name) => {
  const vectors = readVectors(name);
  let core: NetworkCore;
  beforeAll(() => {
    core = loadCore(bytesOf(files[name]));
  });
  const of = (key: string, stack?: number) => vectors.of(key, stack);
  const golden = (stack: number) => core.layer({ bottom: codesOf(stack), coats: [] });
  const codesOf = (stack: number) => ({ kind: "codes", latents: of("latents", stack) }) as const;
  const stacks = vectors.stacks.map(
    ({ bottom, coats }, stack) => [`${bottom.kind} under ${coats.length} coats`, stack] as const,
  );

  test.each(stacks)("%s (%i): codes", (_, stack) => {
    const material = core.layer(vectors.stacks[stack]);
    const { latents } = material;
    expect(relativeError(latents, of("latents", stack), LEAST_CODE)).toBeLessThan(LIMITED[name]);
    const f = core.f(material, of("wi"), of("wo"));
    expect(relativeError(f, of("f", stack))).toBeLessThan(LIMITED[name]);
  });

  test.each(stacks)("%s (%i): f and albedo of given codes", (_, stack) => {
    const material = golden(stack);
    const f = core.f(material, of("wi"), of("wo"));
    expect(relativeError(f, of("f", stack))).toBeLessThan(AGREEMENT);
    const albedo = core.albedo(material, of("cosines"));
    expect(relativeError(albedo, of("albedo", stack))).toBeLessThan(ALBEDO);
  });

  test.each(stacks)("%s (%i): directions of the table", (_, stack) => {
    const drawn = of("drawn", stack);
    const samples = 16;
    const table = core.table(golden(stack), {
      azimuths: 1,
      cosines: drawn.length / samples / 4,
      samples,
      shift: [0, 0, 0],
    });
    const rows = Array.from({ length: drawn.length / 4 }, (_, row) => row);
    const directions = rows.flatMap((row) => [...table.subarray(8 * row, 8 * row + 3)]);
    const densities = rows.map((row) => table[8 * row + 6]);
    const expected = rows.flatMap((row) => [...drawn.subarray(4 * row, 4 * row + 3)]);
    expect(relativeError(directions, expected, 1)).toBeLessThan(AGREEMENT);
    const expectedDensities = rows.map((row) => drawn[4 * row + 3]);
    expect(relativeError(densities, expectedDensities)).toBeLessThan(DENSITY_OF_DRAWN);
  });
});
