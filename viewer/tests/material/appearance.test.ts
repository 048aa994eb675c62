/** Media by their appearance: either description gives the other. */

import { describe, expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import {
  colourOf,
  colourOver,
  lookOf,
  physicsOf,
  withColour,
  withOpacity,
} from "../../src/material/appearance";
import { type Rgb, rgb } from "../../src/material/channels";
import { stackOf } from "../../src/material/material";
import { readMaterial } from "../../src/state/read";
import { bytesOf, SHIPPED } from "../core/vectors";

const shipped = () => loadCore(bytesOf(SHIPPED));
const whiteUnder = (alpha: number, energyCompensation: boolean) =>
  stackOf(
    readMaterial({
      bottom: { kind: "diffuse", reflectance: 1 },
      coats: [{ alpha, ior: 1.5 }],
      energyCompensation,
    }),
  );
const cosines = Float32Array.from({ length: 10 }, (_, k) => 0.1 * (k + 1));

describe("a medium", () => {
  const paint = {
    color: 1,
    body: [0.3, 0.5, 0.9] as Rgb,
    bodyColor: [0.1, 0.5, 0.9] as Rgb,
    g: 0.4,
  };
  const dye = { color: [0.9, 0.4, 0.01] as Rgb, body: 0, bodyColor: 0.8, g: 0 };
  test.each([paint, dye])("has the same look after a change to physics and back", (medium) => {
    const look = lookOf({ ...physicsOf(medium), g: medium.g });
    for (const name of ["color", "body", "bodyColor"] as const)
      rgb(look[name]).forEach((x, k) => {
        expect(x).toBeCloseTo(rgb(medium[name])[k], 6);
      });
  });
  test("that is as thick as two lets the square of its colour pass", () => {
    colourOver(dye, 2).forEach((x, k) => {
      expect(x).toBeCloseTo(dye.color[k] ** 2, 9);
    });
  });
  test("given by physics, in an older address, stays so", () => {
    const { coats } = readMaterial({
      bottom: { kind: "diffuse" },
      coats: [{ albedo: 0.5, sigmaT: 2, g: 0.1, thickness: 3 }],
    });
    expect(coats[0]).toMatchObject({ albedo: 0.5, sigmaT: 2, thickness: 3 });
    expect(coats[0]).not.toHaveProperty("color");
    expect(
      stackOf({ name: "", bottom: { kind: "diffuse", reflectance: 1 }, coats, solo: null }).coats[0]
        .sigmaT,
    ).toBe(6);
  });
});

test("matt clear coats over white reflect all light with energy compensation", () => {
  const core = shipped();
  for (const alpha of [0.05, 0.3, 1]) {
    const plain = core.albedo(core.layer(whiteUnder(alpha, false)), cosines);
    const whole = core.albedo(core.layer(whiteUnder(alpha, true)), cosines);
    if (alpha === 1) expect(Math.max(...plain)).toBeLessThan(0.7);
    // The layering network gives the light below the surface.
    for (const share of whole) expect(Math.abs(share - 1)).toBeLessThan(0.012);
  }
});

test("coats over a white metal get light back and gain none", () => {
  const core = shipped();
  for (const alpha of [0.1, 0.3, 0.6]) {
    const bottom = { kind: "conductor", alpha: 0.05, r0: 1 };
    const [without, found] = [false, true].map((energyCompensation) => {
      const material = readMaterial({ bottom, coats: [{ alpha, ior: 1.5 }], energyCompensation });
      return core.albedo(core.layer(stackOf(material)), cosines);
    });
    // Within 3 %, as in Python: the loss over a mirror is an estimate.
    expect(Math.max(...found!)).toBeLessThan(1.03);
    expect(found!.every((share, at) => share > without![at])).toBe(true);
  }
});

describe("one colour of dye and pigment", () => {
  const clear = { color: 1, body: 0, bodyColor: 0.8, g: 0 } as const;

  test("is that of a clear coat as of an opaque one, whichever order they are given in", () => {
    const red: Rgb = [0.7, 0.05, 0.02];
    const first = withOpacity(withColour(clear, red), 0.4);
    expect(first).toEqual(withColour(withOpacity(clear, 0.4), red));
    expect(colourOf(lookOf(first))).toEqual(red);
    expect(colourOf(lookOf(withOpacity(first, 0)))).toEqual(red);
    expect(withOpacity(first, 0)).toMatchObject({ color: red });
    expect(withOpacity(first, 1)).toMatchObject({ color: 1, bodyColor: red });
  });

  test("is not forced upon a coat of two", () => {
    const two = { ...clear, color: 0.5, body: 0.2, bodyColor: 0.9 };
    expect(withOpacity(two, 0.3)).toEqual({ ...two, body: 0.3 });
  });
});
