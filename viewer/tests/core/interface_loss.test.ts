/** The loss of rough surfaces: that of Python, and energy. */

import { expect, test } from "vitest";
import { COSINES, surfaceLoss } from "../../src/core/interface_loss";
import { hasPython, python } from "../python";

const PLACES = [10, 26, 39, 47];
const CASES = [0.05, 0.3, 0.8].flatMap((alpha) =>
  [0.7, 1.5, Math.fround(1.512 / 1.00027727), 2.5].flatMap((eta) =>
    [0, 0.8, 1].map((mirrored) => [alpha, eta, mirrored] as const),
  ),
);
const VALUES = `
import json, numpy as np
from urushi.checks import Widths
from urushi.core.anisotropic_albedos import surface_loss
z = np.array(${JSON.stringify(PLACES.map((k) => COSINES[k]))})
w = np.stack([np.sqrt(1 - z**2), 0 * z, z], axis=-1)
found = [surface_loss(Widths(a, a), *case) for a, *case in ${JSON.stringify(CASES)}]
print(json.dumps([[*lost(w).tolist(), mean] for lost, mean in found]))
`;

// Needs the project's Python environment, which \`make test-web\` sets up.
test.skipIf(!hasPython)("it is that of Python", { timeout: 120_000 }, () => {
  const known = JSON.parse(python(VALUES));
  CASES.forEach((values, place) => {
    const { at, mean } = surfaceLoss(...values);
    [...PLACES.map((k) => at[k]!), mean].forEach((share, k) => {
      // Both are sums over few facets, some of which reflect totally below an index of 1.
      expect(Math.abs(share - known[place][k]), `${values} ${k}`).toBeLessThan(0.006);
    });
  });
});
