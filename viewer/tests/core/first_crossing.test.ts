/** Layering from the first crossing: random networks give the codes of Python. */

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, readFileSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "vitest";
import { Basis } from "../../src/core/basis";
import { Layerer } from "../../src/core/layerer";
import { activationOf } from "../../src/core/mlp";
import { readWeights } from "../../src/core/weights";

const ROOT = join(import.meta.dirname, "../../..");
const PYTHON = process.env.PYTHON ?? join(ROOT, ".venv/bin/python");
const LAYER = `
import json, sys
import numpy as np
from tests.untrained import untrained
from urushi.checks import CoatParameters
from urushi.nets import weights

folder, rng = sys.argv[1], np.random.default_rng(0)
model = untrained(crossing=64)
model = weights.save(folder + "/weights.safetensors", model.arch, model.params, {})
z = 0.5 * rng.standard_normal((40, model.arch.latent))
z[:, 0], z[:, 1:6] = rng.uniform(0.02, 0.6, 40), rng.uniform(0, 1, (40, 5))
z[:, 3:6] += [0, 1, 1]
z[::7, 6] = -20
alpha, eta = rng.uniform(0.02, 0.8, 40), rng.choice([0.6, 1, 1.3, 1.5, 2.6], 40)
coats = alpha, eta, rng.random(40), rng.uniform(0, 6, 40), rng.uniform(-0.7, 0.8, 40)
z, coats = z.astype(np.float32), np.array(coats, np.float32)
layered = model.networks.layer(z, CoatParameters(*coats))
print(json.dumps([x.tolist() for x in (z, coats.T, layered)]))
`;

// Needs the project's Python environment, which \`make test-web\` sets up.
test.skipIf(!existsSync(PYTHON))("codes are those of Python", { timeout: 120_000 }, () => {
  const folder = mkdtempSync(join(tmpdir(), "urushi-"));
  try {
    const text = execFileSync(PYTHON, ["-c", LAYER, folder], { cwd: ROOT, encoding: "utf-8" });
    const [codes, coats, layered] = JSON.parse(text) as [number[][], number[][], number[][]];
    const bytes = readFileSync(join(folder, "weights.safetensors"));
    const { arch, basis, layerer } = readWeights(Uint8Array.from(bytes).buffer);
    const own = new Basis(basis, arch.lobe);
    const found = new Layerer(arch, own, layerer, activationOf(arch.activation)).layer(
      codes.map((code) => Float32Array.from(code)),
      coats.map(([alpha, eta, albedo, sigmaT, g]) => {
        return { alpha, alphaV: alpha, eta, albedo, sigmaT, g };
      }),
    );
    // Python computes in single precision, of codes of some units.
    layered.flat().forEach((number, k) => {
      const code = found[Math.floor(k / arch.latent)];
      expect(Math.abs(code[k % arch.latent] - number)).toBeLessThan(5e-4);
    });
  } finally {
    rmSync(folder, { recursive: true });
  }
});
