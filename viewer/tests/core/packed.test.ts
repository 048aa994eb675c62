/** The page's own file of weights, of half precision and fewer bits, as Python packs it. */

import { execFileSync } from "node:child_process";
import { expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { stackOf } from "../../src/material/material";
import { PRESETS } from "../../src/material/presets";
import { hasPython, PYTHON } from "../python";
import { bytesOf, pairs, SHIPPED } from "./vectors";

const PACK = `
import sys
from urushi.app.page_files import packed_weights
from urushi.nets.weights import find
sys.stdout.buffer.write(packed_weights(find(None)))
`;

// Needs the project's Python environment.
test.skipIf(!hasPython)("it hardly changes f", () => {
  const bytes = execFileSync(PYTHON, ["-c", PACK], { maxBuffer: 2 ** 24 });
  const [exact, rounded] = [loadCore(bytesOf(SHIPPED)), loadCore(Uint8Array.from(bytes).buffer)];
  const [wi, wo] = pairs();
  const materials = PRESETS.filter(({ bottom }) => !("alphaV" in bottom));
  const errors = materials.map(stackOf).flatMap((stack) => {
    const f = exact.f(exact.layer(stack), wi, wo);
    const near = rounded.f(rounded.layer(stack), wi, wo);
    return [...f].map((value, i) => Math.abs((near[i] as number) / value - 1));
  });
  const known = errors.filter(Number.isFinite).sort((a, b) => a - b);
  // Rounding of many numbers averages out.
  expect(known[Math.floor(known.length / 2)]).toBeLessThan(2 ** -9);
  expect(known[Math.floor(0.99 * known.length)]).toBeLessThan(0.05);
});
