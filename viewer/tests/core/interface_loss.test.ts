/** The loss of rough surfaces: that of Python, and energy. */

import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "vitest";
import { surfaceLoss } from "../../src/core/interface_loss";

const PYTHON = process.env.PYTHON ?? join(import.meta.dirname, "../../../.venv/bin/python");
const COSINES = [0.05, 0.3, 0.7, 1];
const CASES = [0.05, 0.3, 0.8].flatMap((alpha) =>
  [0.7, 1.5, 2.5].flatMap((eta) => [0, 0.8].map((mirrored) => [alpha, eta, mirrored] as const)),
);
const VALUES = `
import json, numpy as np
from urushi.core.albedos import surface_loss
found = [surface_loss(*case) for case in ${JSON.stringify(CASES)}]
print(json.dumps([[*lost(np.array(${JSON.stringify(COSINES)})), mean] for lost, mean in found]))
`;

// Needs the project's Python environment, which \`make test-web\` sets up.
test.skipIf(!existsSync(PYTHON))("it is that of Python", { timeout: 120_000 }, () => {
  const known = JSON.parse(execFileSync(PYTHON, ["-c", VALUES], { encoding: "utf-8" }));
  CASES.forEach((values, place) => {
    const { at, mean } = surfaceLoss(...values, Float32Array.from(COSINES));
    [...at, mean].forEach((share, k) => {
      // Python interpolates between tables of widths and cosines.
      expect(Math.abs(share - known[place][k]), `${values} ${k}`).toBeLessThan(0.004);
    });
  });
});
