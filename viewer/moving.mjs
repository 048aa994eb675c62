/**
 * Measures the moving picture of the page: `PAGE=ADDRESS npm run moving [FOLDER
 * [ENVIRONMENT]]`, with the networks of a page that `urushi view` serves. FRAMES: of a mean, 24 if left out.
 *
 * For every material of the library, draws the first picture after a change and the mean of many
 * frames, in one page, without its interface. Writes both as PNG, and prints FLIP (Andersson et al. 2020)
 * of the first to the mean. Pictures of means that are there already are kept.
 */

import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, writeFileSync } from "node:fs";
import { chromium } from "@playwright/test";
import { createServer } from "vite";

const FOLDER = process.argv[2] ?? "out/moving";
const ENVIRONMENT = process.argv[3] ?? "studio";
const PAGE = process.env.PAGE ?? "http://127.0.0.1:8497/";
const [WIDTH, HEIGHT] = [280, 245];
const FRAMES = Number(process.env.FRAMES ?? 24);

const FLIP = `
import sys
import flip_evaluator
print(format(flip_evaluator.evaluate(*sys.argv[1:], "LDR")[1], ".3f"))
`;

/** Runs in the page: [name, first picture, mean or null] of a material, as addresses of PNG. */
async function pictures([place, isMeanKnown, environment, width, height, frames]) {
  const [
    { PRESETS },
    { stackOf },
    remote,
    engine,
    { Renderer },
    meshes,
    { INITIAL },
    hiding,
    sequence,
  ] = await Promise.all(
    [
      "/src/material/presets.ts",
      "/src/material/material.ts",
      "/src/engine/remote.ts",
      "/src/engine/engine.ts",
      "/src/picture/renderer.ts",
      "/src/picture/meshes.ts",
      "/src/state/state.ts",
      "/src/core/occlusion.ts",
      "/src/core/sequence.ts",
    ].map((path) => import(path)),
  );
  const { SAMPLES, TABLE_ROWS } = engine;
  window.cores ??= new remote.Cores(await remote.connect());
  if (window.renderer === undefined) {
    const canvas = Object.assign(document.createElement("canvas"), { width, height });
    window.renderer = new Renderer(canvas);
    const mesh = meshes.meshOf("goblet");
    window.renderer.setMesh(mesh);
    const { vertices, faces } = mesh;
    window.renderer.setOcclusion(
      hiding.occlusion(vertices, meshes.VERTEX_NUMBERS, faces, meshes.groundSize(mesh)),
    );
    window.renderer.setEnvironment(environment, null);
    window.shown = canvas;
  }
  const { cores, renderer, shown } = window;
  const shot = { ...INITIAL, slot: 0 };
  const preset = PRESETS[place];
  if (preset === undefined) return null;
  const stack = stackOf(preset);
  const core = await cores.of(stack);
  const material = await core.layer(stack);
  const sizes = { ...TABLE_ROWS[core.widths], samples: SAMPLES };
  const draw = async (count, isFirst) => {
    const shift = sequence.sequencePoint(SAMPLES * count, [0, 0, 0]);
    const table = await core.table(material, { ...sizes, shift });
    renderer.material(0).setTable(table, sizes, preset.rotation ?? 0, isFirst);
    renderer.drawFrame(shot, count, 1, 1, 1).next();
  };
  renderer.material(0).setMaterial(material);
  await draw(0, true);
  const first = shown.toDataURL();
  if (isMeanKnown) return [preset.name, first, null];
  for (let count = 0; count < frames; count++) await draw(count, false);
  return [preset.name, first, shown.toDataURL()];
}

const server = await createServer({ server: { port: 0, hmr: false }, logLevel: "error" });
await server.listen();
const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
  args: ["--no-sandbox"],
});
try {
  const page = await browser.newPage();
  page.on("pageerror", (error) => console.error(error));
  await page.route("**/blank", (route) => route.fulfill({ body: "", contentType: "text/html" }));
  await page.route("**/*.safetensors*", async (route) => {
    const { pathname } = new URL(route.request().url());
    await route.fulfill({ response: await route.fetch({ url: new URL(pathname, PAGE).href }) });
  });
  await page.goto(new URL("blank", server.resolvedUrls.local[0]).href);
  mkdirSync(FOLDER, { recursive: true });
  for (let place = 0; ; place++) {
    const path = (kind) => `${FOLDER}/${ENVIRONMENT}-${String(place).padStart(2, "0")}-${kind}.png`;
    const known = existsSync(path("mean"));
    const made = await page.evaluate(pictures, [place, known, ENVIRONMENT, WIDTH, HEIGHT, FRAMES]);
    if (made === null) break;
    const [name, first, mean] = made;
    const write = (kind, address) =>
      writeFileSync(path(kind), Buffer.from(address.split(",")[1], "base64"));
    write("first", first);
    if (mean !== null) write("mean", mean);
    const flip = execFileSync("../.venv/bin/python", ["-c", FLIP, path("mean"), path("first")]);
    console.log(`${String(flip).trim()}  ${name}`);
  }
} finally {
  await browser.close();
  await server.close();
}
