/** What the page saves, in Python: it gives the f that the page computes. */

import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { sequencePoint } from "../../src/core/sequence";
import { materialFile } from "../../src/engine/material_file";
import { isAnisotropic, isCompensated, stackOf } from "../../src/material/material";
import { METALS, preset } from "../../src/material/presets";
import { pythonText } from "../../src/save/python";
import { shaderText } from "../../src/save/shader";
import { readMaterial } from "../../src/state/read";
import { bytesOf, pairs, relativeError, SHIPPED, SHIPPED_ANISOTROPIC } from "../core/vectors";
import { Draws } from "../material/random";
import { folderOfTest, hasPython, python } from "../python";

const EVALUATE = join(import.meta.dirname, "evaluate.py");
const NETWORKS = `
import json
from urushi.export.program import template_text
from urushi.nets.weights import find
models = map(find, (None, "anisotropic"))
print(json.dumps([[template_text("python", model), model.fingerprint] for model in models]))
`;

const [wi, wo] = pairs();

/** Cosines of the albedo, and sizes and numbers of a table of drawn directions. */
const COSINES = Float32Array.of(1, 0.7, 0.3, 0.05);
const DRAWN = { azimuths: 1, cosines: 4, samples: 16, shift: [0, 0, 0] } as const;
const UNIFORM = Array.from({ length: DRAWN.samples }, (_, k) =>
  sequencePoint(k + 1, [0.5, 0.5, 0.5]),
);
const INPUT = { wi: [...wi], wo: [...wo], cosines: [...COSINES], rows: DRAWN.cosines, u: UNIFORM };

/** Bottoms and coats whose ratios of indices depend on what lies above them. */
const VARNISH = { alpha: 0.05, ior: 1.5, sigmaT: [0.1, 0.3, 0.9] };
const MATT = { alpha: 0.8, color: [0.9, 0.6, 0.3] };
const COMPENSATED = [
  { bottom: { kind: "conductor", alpha: 0.3, r0: [0.2, 0.1, 0.05] }, coats: [MATT] },
  { bottom: { kind: "diffuse", reflectance: 0.8 }, coats: [MATT] },
  { bottom: { kind: "diffuse", reflectance: 0.8 }, coats: [{ ...MATT, ior: 0.7 }] },
  { bottom: { kind: "diffuse", reflectance: 0.05 }, coats: [{ alpha: 0.05, ior: 0.7 }] },
  { bottom: { kind: "conductor", alpha: 0.35, r0: [1, 0.6, 0.2] } },
  { bottom: { kind: "conductor", alpha: [0.2, 0.6, 1], ...METALS.Gold } },
].map((material) => ({ ...material, energyCompensation: true }));
const UNDER_VARNISH = [
  { bottom: { kind: "conductor", alpha: 0.2, ...METALS.Gold }, coats: [VARNISH] },
  { bottom: { kind: "dielectric", alpha: 0.2, ior: 1.9 }, coats: [VARNISH] },
  { bottom: { kind: "diffuse" }, coats: [VARNISH, { alpha: 0.1, ior: 1.5 }] },
  { bottom: { kind: "diffuse" }, coats: [VARNISH, { alpha: 0.1, ior: 1.7, sigmaT: 1 }] },
  { bottom: { kind: "diffuse" }, coats: [{ color: [0.9, 0.6, 0.3], thickness: 2 }] },
  { bottom: { kind: "diffuse" }, coats: [{ body: 0.4, bodyColor: [0.8, 0.3, 0.1], g: 0.3 }] },
  { bottom: { kind: "diffuse" }, coats: [{ alpha: 0.1, ior: 0.7, sigmaT: [0, 0.2, 1] }] },
  { bottom: { kind: "dielectric", ior: 0.6 }, coats: [{ ior: 0.51 }, { ior: 3 }, { ior: 0.51 }] },
  ...COMPENSATED,
].map((material) => readMaterial(material));
const folder = folderOfTest();

// Needs the project's Python environment, which `make test-web` sets up.
test.skipIf(!hasPython)(
  "a saved material, its code and its program give the page's f",
  { timeout: 120_000 },
  () => {
    const cores = [SHIPPED, SHIPPED_ANISOTROPIC].map((file) => loadCore(bytesOf(file)));
    const networks: [template: string, fingerprint: string][] = JSON.parse(python(NETWORKS));
    const own = ["Vermilion urushi", "Candy blue car paint", "White enamel"].map(preset);
    const draws = new Draws(5);
    const drawn = Array.from({ length: 12 }, (_, k) => draws.material(k % 3 === 0));
    const given = [...own, ...UNDER_VARNISH];
    const cards = [...given, ...drawn];
    const expected = cards.map((material, place) => {
      const files = join(folder, String(place));
      mkdirSync(files);
      const stack = stackOf(material);
      const at = Number(isAnisotropic(stack));
      const core = cores[at];
      const [template, fingerprint] = networks[at];
      const codes = core.layer(stack);
      const { latentSize, widths } = core;
      const file = materialFile(codes, { latentSize, widths, fingerprint });
      writeFileSync(join(files, "input.json"), JSON.stringify(INPUT));
      writeFileSync(join(files, "material.safetensors"), file);
      writeFileSync(join(files, "material-numpy.py"), shaderText(template, codes));
      writeFileSync(join(files, "basis.f32"), core.basisTexels());
      writeFileSync(join(files, "program.py"), pythonText({ ...material, rotation: 0 }));
      const table = core.table(codes, DRAWN);
      const drawn = (from: number, to: number) =>
        Array.from({ length: table.length / 8 }, (_, row) => [
          ...table.subarray(8 * row + from, 8 * row + to),
        ]).flat();
      const albedo = core.albedo(codes, COSINES);
      return { f: core.f(codes, wi, wo), albedo, drawn: drawn(0, 3), densities: drawn(6, 7) };
    });
    const folders = cards.map((_, place) => join(folder, String(place)));
    const values = JSON.parse(python(EVALUATE, ...folders));
    expect(values.length).toBe(cards.length);
    for (const [place, { f, albedo, drawn, densities }] of expected.entries()) {
      const found = values[place];
      // Python computes in single precision: roundings of sums of many terms, and of least squares.
      // Tables of materials with energy compensation are of half precision in files and in Python,
      // and steep below a lower index, where roundings of coordinates count.
      const hasTable = isCompensated(cards[place]);
      expect(relativeError(found.loaded, f)).toBeLessThan(hasTable ? 6e-3 : 5e-4);
      expect(relativeError(found.albedo, albedo, 0.01)).toBeLessThan(hasTable ? 6e-3 : 2e-3);
      // Directions of sharp lobes amplify rounding by 1 / alpha.
      expect(relativeError(found.drawn, drawn, 1)).toBeLessThan(1e-3);
      // They follow the transmittance, which is steep beside the critical angle.
      expect(relativeError(found.densities, densities)).toBeLessThan(0.02);
      // The channels of two widths have a stretch each, those of code share one.
      const hasCode = !hasTable && !isAnisotropic(stackOf(cards[place]));
      if (hasCode) expect(relativeError(found.code, f)).toBeLessThan(2e-4);
      const most = place < given.length ? [5e-4, 4e-3] : [1e-3, 4e-3];
      expect(relativeError(found.program, f)).toBeLessThan(most[Number(hasTable)]);
    }
  },
);
