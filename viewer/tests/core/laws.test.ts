/** Laws that hold for networks of any weights: reciprocity, energy, normalisation. */

import { beforeAll, describe, expect, test } from "vitest";
import type { Bottom, Coat, Material, Stack } from "../../src/core/api";
import { Basis } from "../../src/core/basis";
import { rows } from "../../src/core/channels";
import { loadCore, type NetworkCore } from "../../src/core/core";
import { EnergyLimit } from "../../src/core/energy";
import { mixtureDensity, proposalOf } from "../../src/core/mixture";
import { directionRule } from "../../src/core/quadrature";
import { readWeights } from "../../src/core/weights";
import { type MaterialCards, stackOf, withCoat } from "../../src/material/material";
import { preset } from "../../src/material/presets";
import { ENERGY } from "../../src/printed/formulas";
import { bytesOf, pairs, SHIPPED } from "./vectors";

const STACK: Stack = {
  bottom: { kind: "diffuse", reflectance: [0.8, 0.5, 0.1] },
  coats: [
    { alpha: 0.1, eta: 1.5, albedo: 0, sigmaT: 0, g: 0 },
    { alpha: 0.3, eta: 1.3, albedo: [0.9, 0.5, 0.2], sigmaT: 1, g: 0.3 },
  ],
};

let core: NetworkCore;
let material: Material;

beforeAll(() => {
  core = loadCore(bytesOf(SHIPPED));
  material = core.layer(STACK);
});

describe("f", () => {
  test("is reciprocal to the last bit", () => {
    const [wi, wo] = pairs();
    expect(core.f(material, wi, wo)).toEqual(core.f(material, wo, wi));
  });

  test("is zero below the horizon and positive above", () => {
    const up = Float32Array.of(0.6, 0, 0.8);
    const down = Float32Array.of(0, 0.6, -0.8);
    expect(core.f(material, up, down)).toEqual(Float32Array.of(0, 0, 0));
    expect(Math.min(...core.f(material, up, up))).toBeGreaterThan(0);
  });
});

describe("energy", () => {
  // Beside a lobe that reflects totally, the rest may have LEAST_REST more, and between the angles
  // of the limit, one of which is .02 from the critical one, some more.
  test.each([
    [1.5, 1.001],
    [0.7, 1.016 + ENERGY.LEAST_REST],
  ])("a limited code below an index %f reflects at most all light", (eta, most) => {
    const [top, ...others] = STACK.coats;
    const own = core.layer({ ...STACK, coats: [{ ...top, eta }, ...others] });
    const bright = own.latents.map((number, k) => number + (k % core.latentSize === 6 ? 3 : 0));
    const { arch, basis } = readWeights(bytesOf(SHIPPED));
    const energy = new EnergyLimit(new Basis(basis, arch.lobe), arch.lobe);
    const limited = bright.slice();
    for (const code of rows(limited, core.latentSize)) energy.limit(code);
    const cosines = Float32Array.from({ length: 12 }, (_, i) => (i + 0.5) / 12);
    const albedoOf = (latents: Float32Array) =>
      core.albedo(core.layer({ bottom: { kind: "codes", latents }, coats: [] }), cosines);
    const [before, after] = [albedoOf(bright), albedoOf(limited)];
    expect(Math.max(...before)).toBeGreaterThan(1.2);
    expect(Math.max(...after)).toBeLessThan(most); // the quadrature's own error is 0.001
  });

  test("a rough white metal reflects all light once it is compensated", () => {
    const cosines = Float32Array.of(0.05, 0.2, 0.5, 0.8, 1);
    for (const alpha of [0.05, 0.3, 0.6, 1]) {
      const bottom = { kind: "conductor", alpha, r0: 1 } as const;
      const white = core.layer({ bottom, coats: [], energyCompensation: true });
      for (const albedo of core.albedo(white, cosines))
        expect(Math.abs(albedo - 1)).toBeLessThan(0.006); // of tables, in width and in directions
    }
  });

  test("a coat of the same index hardly changes vermilion's red", () => {
    const shipped = loadCore(bytesOf(SHIPPED));
    const red = (material: MaterialCards) =>
      shipped.albedo(shipped.layer(stackOf(material)), Float32Array.of(Math.SQRT1_2))[0];
    const vermilion = preset("Vermilion urushi");
    const before = red(vermilion);
    let material = vermilion;
    for (let coats = 0; coats < 4; coats++) {
      material = withCoat(material);
      expect(Math.abs(red(material) / before - 1)).toBeLessThan(0.08); // of a rougher surface, and four errors of the network
    }
  });
});

describe("layering", () => {
  test("over the codes of a surface is layering over the surface", () => {
    const codes = { kind: "codes", latents: core.encode(STACK.bottom) } as const;
    expect(core.layer({ bottom: codes, coats: STACK.coats })).toEqual(core.layer(STACK));
  });

  test("a coat without an interface and a medium changes nothing, whatever its width", () => {
    const bottom: Bottom = { kind: "conductor", alpha: 0.2, eta: [0.14, 0.37, 1.44], k: 3 };
    const absent: Coat = { alpha: 1, eta: 1, albedo: 0.5, sigmaT: 0, g: 0 };
    expect(core.layer({ bottom, coats: [absent] })).toEqual(core.layer({ bottom, coats: [] }));
  });

  test("parameters at the ends of their ranges give finite values", () => {
    const ends = [
      { alpha: 0.01, eta: 0.5, albedo: 0, sigmaT: 0, g: -0.999 },
      { alpha: 1, eta: 3, albedo: 1, sigmaT: 1e6, g: 0.999 },
      { alpha: 0.01, eta: 1.001, albedo: 1, sigmaT: 1e-9, g: 0 },
      { alpha: 1, eta: 0.999, albedo: 0, sigmaT: 50, g: 0 },
    ];
    const bottoms: Bottom[] = [
      { kind: "diffuse", reflectance: [0, 1, 0.5] },
      { kind: "conductor", alpha: 0.01, r0: [0, 1, 0.5] },
      { kind: "conductor", alpha: 1, eta: [0, 0.05, 5], k: [0, 10, 0] },
    ];
    for (const bottom of bottoms) {
      for (const coat of ends) {
        const found = core.layer({ bottom, coats: [coat, coat, ...ends] });
        const table = core.table(found, {
          azimuths: 1,
          cosines: 4,
          samples: 16,
          shift: [0, 0, 0.99],
        });
        expect(found.latents.every(Number.isFinite)).toBe(true);
        expect(table.every(Number.isFinite)).toBe(true);
        expect(Math.min(...table)).toBeGreaterThan(-1.001); // directions; nothing else is below 0
      }
    }
  });
});

describe("the proposal", () => {
  test.each([0.95, 0.5, 0.1])("integrates to one at the cosine %f", (cosine) => {
    const wi = { x: Math.sqrt(1 - cosine * cosine), y: 0, z: cosine };
    const { wo, weights } = directionRule(wi, 1, [48, 16, 1e-3, 1e-5]);
    const { arch, proposal } = readWeights(bytesOf(SHIPPED));
    const code = material.latents.slice(0, core.latentSize);
    const mixture = proposalOf(proposal, arch.lobe, code)(wi);
    const total = weights.reduce((sum, weight, i) => {
      const [x, y, z] = wo.slice(3 * i, 3 * i + 3);
      return sum + (mixtureDensity(mixture, wi, { x, y, z }) / z) * weight;
    }, 0);
    expect(total).toBeCloseTo(1, 2);
  });

  test("the mean of a table's weights is the albedo", () => {
    const [cosines, samples] = [4, 4096];
    const table = core.table(material, { azimuths: 1, cosines, samples, shift: [0.2, 0.4, 0.7] });
    const angles = Float32Array.from({ length: cosines }, (_, row) => (row + 0.5) / cosines);
    const albedo = core.albedo(material, angles);
    for (let row = 0; row < cosines; row++) {
      for (let channel = 0; channel < 3; channel++) {
        let sum = 0;
        for (let i = 0; i < samples; i++) {
          sum += table[(row * samples + i) * 8 + 3 + channel];
        }
        const expected = albedo[3 * row + channel];
        expect(Math.abs(sum / samples / expected - 1)).toBeLessThan(0.02);
      }
    }
  });
});
