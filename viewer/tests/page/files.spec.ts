/** Opening and saving: good files, bad files, and what is written is read again. */

import type { Page } from "@playwright/test";
import { rglTensors, tensorFile } from "../core/measured/files";
import { coats, expect, give, number, open, panorama, saved, test } from "./page";

for (const [name, content, sentence] of [
  ["notes.txt", "hello", "The page opens materials"],
  ["broken.safetensors", "hello", "damaged or no material"],
  ["broken.bsdf", "tensor_file\0\u0001", "header is truncated"],
  ["broken.binary", "hello", "neither a MERL table"],
  ["broken.hdr", "hello", "no .hdr panorama"],
  ["short.hdr", "#?RADIANCE\n\n-Y 4 +X 8\n1234", "damaged or incomplete"],
  ["broken.json", "{", "no JSON text"],
  ["empty.json", "{}", "has no materials"],
] as const)
  test(`${name} is refused in a sentence`, async ({ page }) => {
    await open(page);
    await give(page, name, content);
    await expect(page.getByRole("alert")).toContainText(sentence);
    await expect(coats(page)).toHaveCount(2);
    await expect(page.locator(".status")).toBeVisible();
  });

test("a panorama becomes the light", async ({ page }) => {
  await open(page);
  await give(page, "evening.hdr", panorama(64, 32, [128, 64, 32, 129]));
  await expect(page.getByRole("combobox", { name: "Light" })).toHaveValue("own");
  await expect(page.getByRole("combobox", { name: "Light" })).toContainText("evening.hdr");
});

test("a measured BRDF is encoded and coated", async ({ page }) => {
  await open(page);
  const file = Buffer.from(tensorFile(rglTensors([0.3, 0.2, 0.1])));
  await give(page, "gypsum.bsdf", file);
  await expect(page.getByRole("button", { name: /^Material gypsum/ })).toBeVisible();
  await expect(coats(page)).toHaveCount(0);
  await page.getByRole("button", { name: "Add coat" }).click();
  await expect(coats(page)).toHaveCount(1);
  await expect(page.locator(".status[data-converged]")).toBeVisible();
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("a saved state is opened again", async ({ page }) => {
  await open(page);
  await number(page, "Coat 2, Index η").fill("1.61");
  await number(page, "Coat 2, Index η").press("Enter");
  const state = await saved(page, "State");
  expect(state.name).toBe("vermilion-urushi.json");
  await page.getByRole("button", { name: "Remove Coat 2" }).click();
  await give(page, state.name, state.text);
  await expect(coats(page)).toHaveCount(2);
  await expect(number(page, "Coat 2, Index η")).toHaveValue("1.61");
});

test("descriptions and a picture are saved", async ({ page }) => {
  await open(page);
  const xml = await saved(page, "Mitsuba XML");
  expect(xml.name).toBe("vermilion-urushi.xml");
  const nodes = await page.evaluate((text) => {
    const parsed = new DOMParser().parseFromString(text, "application/xml");
    return [...parsed.querySelectorAll("bsdf")].map((node) => node.getAttribute("type"));
  }, xml.text);
  expect(nodes).toEqual(["neural_layered", "neural_layered", "diffuse"]);
  expect((await saved(page, "Python")).text).toContain("urushi.diffuse(reflectance=(0.1, 0.05");
  expect((await saved(page, "Picture")).text.slice(1, 4)).toBe("PNG");
});

test("a saved material is opened again and coated", async ({ page }) => {
  await open(page);
  const { name, text } = await saved(page, "Material ?safetensors");
  expect(name).toBe("vermilion-urushi.safetensors");
  await give(page, name, Buffer.from(text, "latin1"));
  await expect(coats(page)).toHaveCount(0);
  await expect(page.getByRole("alert")).toHaveCount(0);
  await page.getByRole("button", { name: "Add coat" }).click();
  await expect(coats(page)).toHaveCount(1);
});

test("saved shader code compiles", async ({ page }) => {
  await open(page);
  for (const [title, suffix] of [
    ["GLSL", ".glsl"],
    ["WGSL", ".wgsl"],
    ["HLSL", ".hlsl"],
    ["Slang", ".slang"],
    ["OSL", ".osl"],
    ["NumPy", "-numpy.py"],
  ]) {
    const { name, text } = await saved(page, `${title}$`);
    expect(name).toBe(`vermilion-urushi${suffix}`);
    expect(text).not.toMatch(/code_\d/);
    if (title === "GLSL") expect(await compileLog(page, text)).toBe("");
  }
});

/** What WebGL2 says of functions in GLSL; "" if they compile. */
function compileLog(page: Page, functions: string): Promise<string> {
  const main = "void main() { colour = vec4(urushi_f(urushi_material(), wi, wo), 1.0); }";
  const head = "#version 300 es\nprecision highp float; in vec3 wi, wo; out vec4 colour;\n";
  return page.evaluate(
    (source) => {
      const gl = document.createElement("canvas").getContext("webgl2")!;
      const shader = gl.createShader(gl.FRAGMENT_SHADER)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      return gl.getShaderInfoLog(shader) ?? "";
    },
    head + functions + main,
  );
}
