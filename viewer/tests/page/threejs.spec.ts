/** The example with three.js: its pixels are those of `Material.f`. */

import { join } from "node:path";
import type { Page } from "@playwright/test";
import { encoded } from "../../src/material/colour";
import { folderOfTest, python } from "../python";
import { expect, pixelsOf, test } from "./page";

interface Pixel {
  place: [number, number];
  lights: number[];
  sky: number[];
}

const SIZE = 84;
const EXAMPLE = join(import.meta.dirname, "../../../examples/threejs");
const MODULES = join(import.meta.dirname, "../../node_modules");

test.use({ deviceScaleFactor: 1, picture: true });

let folder: string;
let pixels: Pixel[];

test.beforeAll(() => {
  folder = folderOfTest();
  const script = join(import.meta.dirname, "sphere.py");
  pixels = JSON.parse(python(script, folder, String(SIZE)));
});

/** Open the example, served from its folder, with the packages of this one. */
async function show(page: Page, baseURL: string, samples: number): Promise<void> {
  const root = new URL("threejs/", baseURL).href;
  await page.route(`${root}**`, (route) => {
    const path = new URL(route.request().url()).pathname.split("/threejs/")[1];
    const [first, ...rest] = path.split("/");
    if (first === "node_modules") return route.fulfill({ path: join(MODULES, ...rest) });
    if (first!.startsWith("material.")) return route.fulfill({ path: join(folder, first) });
    return route.fulfill({ path: join(EXAMPLE, path) });
  });
  await page.setViewportSize({ width: SIZE, height: SIZE });
  await page.goto(`${root}index.html?samples=${samples}`);
  await expect(page.locator("body[data-drawn]")).toHaveCount(1);
}

/** The differences of the picture from what is expected, in steps of the screen. */
async function errors(page: Page, expected: (pixel: Pixel, channel: number) => number) {
  const { data, width } = await pixelsOf(page, await page.screenshot());
  return pixels.flatMap((pixel) => {
    const [x, y] = pixel.place;
    const colour = data.subarray(4 * (y * width + x));
    return [0, 1, 2].map((k) => Math.abs(colour[k] - 255 * encoded(expected(pixel, k))));
  });
}

test("lights give f times irradiance and cosine, and the sky comes out by the exported sampling", {
  tag: "@long",
}, async ({ page, baseURL }) => {
  await show(page, baseURL!, 0);
  const found = await errors(page, ({ lights }, k) => lights[k]);
  expect(found.length).toBeGreaterThan(150);
  // One step is rounding; the triangles of the sphere move the steep edge of a highlight.
  expect(Math.max(...found)).toBeLessThan(2);

  await show(page, baseURL!, 64);
  const lit = await errors(page, ({ lights, sky }, k) => lights[k] + sky[k]);
  // 64 points of a sequence, of weights near 1, leave an error of a few percent of the sky.
  expect(Math.max(...lit)).toBeLessThan(8);
});
