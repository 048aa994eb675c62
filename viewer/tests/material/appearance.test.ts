/** Media by their appearance: the formulas are Python's, and either description gives the other. */

import { describe, expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { coatedColor } from "../../src/core/formulas";
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
import { hasPython, python } from "../python";

const PROGRAM = `
import json, sys
import numpy as np
from urushi.checks import CoatParameters
from urushi.core.appearance import coated_color, medium
from urushi.core.namespace import NUMPY
media = [[np.asarray(x).tolist() for x in medium(m[:3], m[3])] for m in json.loads(sys.argv[1])]
coats = json.loads(sys.argv[2])
colors = [float(coated_color(CoatParameters(None, *c[:4]), c[4], NUMPY)) for c in coats]
print(json.dumps({"media": media, "colors": colors}))
`;

/** Colour, body, body colour and asymmetry. */
const MEDIA = [
  [1, 0, 0.8, 0],
  [0.5, 0, 0.8, 0.3],
  [0, 0.4, 0.1, -0.5],
  [0.9, 0.7, 0.6, 0.8],
  [1, 1, 0.99, 0],
] as const;
/** Relative index, albedo, optical depth, asymmetry, and the reflectance below. */
const COATS: [number, number, number, number, number][] = [
  [1.5, 0, 0, 0, 1],
  [1.5, 0.2, 1.5, 0.3, 0.6],
  [1.33, 0.98, 8, -0.5, 0.1],
  [0.7, 0.5, 0.2, 0, 0.9],
];

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

// Needs the project's Python environment, which `make test-web` sets up.
test.skipIf(!hasPython)("values are those of Python", { timeout: 120_000 }, () => {
  const known = JSON.parse(python(PROGRAM, JSON.stringify(MEDIA), JSON.stringify(COATS)));
  for (const [place, [color, body, bodyColor, g]] of MEDIA.entries()) {
    const { albedo, sigmaT } = physicsOf({ color, body, bodyColor, g });
    expect(albedo).toBeCloseTo(known.media[place][0], 9);
    expect(sigmaT).toBeCloseTo(known.media[place][1], 9);
  }
  for (const [place, coat] of COATS.entries())
    expect(coatedColor(...coat)).toBeCloseTo(known.colors[place], 9);
});

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
        expect(x).toBeCloseTo(rgb(medium[name])[k]!, 6);
      });
  });
  test("that is as thick as two lets the square of its colour pass", () => {
    colourOver(dye, 2).forEach((x, k) => {
      expect(x).toBeCloseTo(dye.color[k]! ** 2, 9);
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
      stackOf({ name: "", bottom: { kind: "diffuse", reflectance: 1 }, coats, solo: null })
        .coats[0]!.sigmaT,
    ).toBe(6);
  });
});

test("matt clear coats over white reflect all light with energy compensation, and f is reciprocal", () => {
  const core = shipped();
  for (const alpha of [0.05, 0.3, 1]) {
    const plain = core.albedo(core.layer(whiteUnder(alpha, false)), cosines);
    const material = core.layer(whiteUnder(alpha, true));
    const whole = core.albedo(material, cosines);
    if (alpha === 1) expect(Math.max(...plain)).toBeLessThan(0.7);
    // The layering network gives the light below the surface.
    for (const share of whole) expect(Math.abs(share - 1)).toBeLessThan(0.01);
  }
  const material = core.layer(whiteUnder(0.5, true));
  const [a, b] = [Float32Array.of(0.6, 0, 0.8), Float32Array.of(0, 0.96, 0.28)];
  core.f(material, a, b).forEach((x, k) => {
    expect(x).toBeCloseTo(core.f(material, b, a)[k]!, 6);
  });
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
    expect(found!.every((share, at) => share > without![at]!)).toBe(true);
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
