/** The files of the basis's texture, beside those of Python's `urushi export`. */

import { readFileSync } from "node:fs";
import { join } from "node:path";
import { expect, test } from "vitest";
import { loadCore } from "../../src/core/core";
import { basisFile, type Format } from "../../src/save/basis_texture";
import { bytesOf, SHIPPED } from "../core/vectors";
import { folderOfTest, hasPython, python } from "../python";

const WRITE = `
import sys
import numpy as np
from urushi.export.rest import TextureForm, basis_texture
from urushi.nets.weights import find
from urushi.textures.gpu import Image, dds
basis, (first, second, third) = find(None), sys.argv[1:]
texture = basis_texture(basis, TextureForm())
np.save(first, texture)
open(second, "wb").write(dds(Image(texture, is_volume=True)))
basis_texture(basis, TextureForm(axes=2, numbers=3)).astype(np.float32).tofile(third)
`;

// Needs the project's Python environment.
test.skipIf(!hasPython)("files are those of Python", { timeout: 60_000 }, async () => {
  const folder = folderOfTest();
  const paths = ["basis.npy", "basis.dds", "basis.f32"].map((name) => join(folder, name));
  python(WRITE, ...paths);
  const [npy, dds, image] = paths.map((path) => readFileSync(path)) as [Buffer, Buffer, Buffer];
  const texels = loadCore(bytesOf(SHIPPED)).basisTexels();
  const found = async (format: Format) =>
    Buffer.from(await basisFile(texels, format).arrayBuffer());
  expect((await found("npy")).equals(npy)).toBe(true);
  expect((await found("dds")).equals(dds)).toBe(true);
  const exr = await found("exr");
  // Rows of the channels in turn, each behind eight bytes, at the end of the file.
  const width = image.length / (12 * 96);
  const row = 8 + 12 * width;
  const start = exr.length - 96 * row;
  for (const [y, x] of [
    [0, 0],
    [17, 1000],
    [95, width - 1],
  ] as const)
    [2, 1, 0].forEach((channel, place) => {
      const value = exr.readFloatLE(start + y * row + 8 + 4 * (place * width + x));
      const half = image.readFloatLE(4 * (3 * (y * width + x) + channel));
      expect(Math.abs(value - half)).toBeLessThanOrEqual(2 ** -11 * Math.abs(value) + 1e-7);
    });
});
