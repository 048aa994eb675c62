/** A measured file is encoded as Python encodes it. */

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, writeFileSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { expect, test } from "vitest";
import { loadCore } from "../../../src/core/core";
import { logsOf, nodePairs } from "../../../src/core/f_table";
import { Pairs } from "../../../src/core/features";
import { readMeasured, valuesAt } from "../../../src/core/measured/read";
import { materialFile, readMaterialFile } from "../../../src/engine/material_file";
import { tables } from "../../../src/engine/textures";
import { bytesOf, readVectors, relativeError, SHIPPED } from "../vectors";
import { merlFile } from "./files";

const PYTHON = process.env.PYTHON ?? join(import.meta.dirname, "../../../../.venv/bin/python");
const FILE = join(process.env.URUSHI_TEST_DATA ?? "", "data/rgl/cc_green_malachite_rgb.bsdf");
const ENCODE = `
import json, sys, warnings
import numpy as np
import urushi
warnings.simplefilter("ignore")
pairs = np.array(json.load(sys.stdin), np.float32).reshape(2, -1, 3)
whole = urushi.encode(urushi.load_measured(sys.argv[1]))
codes = urushi.Material(whole.latents, whole.model)
print(json.dumps([m.f(*pairs).ravel().tolist() for m in (whole, codes)]))
`;

const VALUES = `
import json, sys
import numpy as np
import urushi
from safetensors.numpy import load_file
from urushi.core.table import node_pairs, table_of_values
from urushi.nets.weights import find
pairs = np.array(json.load(sys.stdin), np.float32).reshape(2, -1, 3)
brdf, saved = urushi.load_measured(sys.argv[1]), load_file(sys.argv[2])
model = find(None)  # of a file of networks without a fingerprint
saved = urushi.Material(saved["latents"], model, saved["table"], beside_lobe=True)
table = table_of_values(brdf.f(*node_pairs())).astype(float)
print(json.dumps({
    "values": brdf.f(*pairs).T.tolist(),
    "saved": saved.f(*pairs).ravel().tolist(),
    "apart": np.abs(saved.table - table).max(),
}))
`;

const vectors = readVectors("default");

/** The sum of the absolute differences relative to that of the expected values. */
function deviation(found: Float32Array, expected: readonly number[]): number {
  const sum = expected.reduce((total, value) => total + value, 0);
  return expected.reduce((total, value, i) => total + Math.abs(found[i]! - value), 0) / sum;
}

// Needs the project's Python environment and the measured files of its tests.
test.skipIf(!existsSync(PYTHON) || !existsSync(FILE) || vectors === undefined)(
  "an RGL material has Python's table and codes",
  { timeout: 300_000 },
  () => {
    const core = loadCore(bytesOf(SHIPPED));
    const [wi, wo] = [vectors!.of("wi"), vectors!.of("wo")];
    const input = JSON.stringify([...wi, ...wo]);
    const [tabulated, f] = JSON.parse(
      execFileSync(PYTHON, ["-c", ENCODE, FILE], { input, encoding: "utf-8" }),
    );
    const { latents, table } = core.encodeMeasured(bytesOf(FILE));
    // Half numbers of logarithms up to 8 are rounded to 0.4 %, most of them less.
    expect(deviation(core.f({ latents, table }, wi, wo), tabulated)).toBeLessThan(1e-3);
    const reread = readMaterialFile(materialFile({ latents, table }, core), core);
    expect(tables.value.get(reread.bottom.table!)).toEqual(table!.logs);
    // Python computes in single precision, the page in double.
    const coded = core.layer({ bottom: { kind: "codes", latents }, coats: [] });
    expect(deviation(core.f(coded, wi, wo), f)).toBeLessThan(0.001);
  },
);

test.skipIf(!existsSync(PYTHON) || vectors === undefined)(
  "a MERL table with gaps has Python's values, and the material with its table Python's f",
  { timeout: 300_000 },
  () => {
    const folder = mkdtempSync(join(tmpdir(), "urushi-"));
    try {
      const file = merlFile((h, d, phi) => {
        const isMeasured = Math.sin(40 * h) + Math.cos(9 * d) * Math.sin(6 * phi) > -0.4;
        return isMeasured ? [0.1 + h, 0.2 + d, 0.3 + phi] : [-1, -1, -1];
      });
      const path = join(folder, "gaps.binary");
      writeFileSync(path, new Uint8Array(file));
      const above = (name: string) => vectors!.of(name).subarray(0, 3 * 63); // the last is below
      const [wi, wo] = [above("wi"), above("wo")];
      const input = JSON.stringify([...wi, ...wo]);
      const core = loadCore(bytesOf(SHIPPED));
      const logs = logsOf(valuesAt(readMeasured(file), nodePairs()));
      const codes = new Float32Array(3 * core.latentSize).fill(0.3);
      const material = { latents: codes, table: { logs, besideLobe: true } };
      writeFileSync(`${path}.safetensors`, materialFile(material, core));
      const files = [path, `${path}.safetensors`];
      const {
        values: expected,
        saved,
        apart,
      } = JSON.parse(
        execFileSync(PYTHON, ["-c", VALUES, ...files], { input, encoding: "utf-8" }),
      ) as { values: number[][]; saved: number[]; apart: number };
      // At half angles of 3e-5, azimuths of directions in single precision are off by some 0.004.
      expect(apart).toBeLessThan(0.01);
      expect(relativeError(core.f(material, wi, wo), saved)).toBeLessThan(1e-4);
      valuesAt(readMeasured(file), Pairs.of(wi, wo)).forEach((values, channel) => {
        values.forEach((value, i) => {
          expect(value).toBeCloseTo(expected[channel]![i]!, 5);
        });
      });
    } finally {
      rmSync(folder, { recursive: true });
    }
  },
);
