/** Opening and saving: good files, bad files, and what is written is read again. */

import { writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Page } from "@playwright/test";
import { exrFile } from "../../src/save/exr";
import { toJson } from "../../src/state/address";
import type { State } from "../../src/state/state";
import { folderOfTest } from "../python";
import { coats, enter, expect, give, number, open, panorama, saved, stateOf, test } from "./page";

test("what cannot be read is refused in a sentence", async ({ page }) => {
  await open(page);
  for (const [name, content, sentence] of [
    ["notes.txt", "hello", "The page opens materials"],
    ["broken.safetensors", "hello", "is no safetensors file"],
    ["gypsum.bsdf", "tensor_file\0\u0001", "run urushi view gypsum.bsdf"],
    ["car.mtlx", "<materialx/>", "run urushi convert"],
    ["broken.hdr", "hello", ".hdr file is damaged"],
    ["broken.exr", "v/1\u0001hello", ".exr file is damaged"],
    ["broken.json", "{", "no JSON text"],
    ["empty.json", "{}", "has no materials"],
  ] as const) {
    await give(page, name, content);
    await expect(page.getByRole("alert")).toContainText(sentence);
    await expect(coats(page)).toHaveCount(2);
    await expect(page.locator(".status")).toBeVisible();
    await page.getByRole("button", { name: "Close" }).click();
    await expect(page.getByRole("alert")).toHaveCount(0);
  }
});

test("a panorama becomes the light, and one that was not opened here is told", async ({ page }) => {
  await open(page);
  const pixels = new Float32Array(3 * 8 * 4).fill(0.5);
  await give(page, "noon.exr", Buffer.from(exrFile({ width: 8, height: 4, pixels })));
  await expect(page.getByRole("combobox", { name: "Light" })).toContainText("noon.exr");
  await give(page, "evening.hdr", panorama(64, 32, [128, 64, 32, 129]));
  await expect(page.getByRole("combobox", { name: "Light" })).toHaveValue("own");
  await expect(page.getByRole("combobox", { name: "Light" })).toContainText("evening.hdr");

  const materials = [{ bottom: { kind: "diffuse" } }];
  const state = { materials, environment: "own", panorama: "night.hdr" };
  await give(page, "state.json", JSON.stringify(state));
  const told = "The panorama “night.hdr” is no part of the address or the state";
  await expect(page.getByRole("alert")).toContainText(told);
  await give(page, "night.hdr", panorama(64, 32, [128, 64, 32, 129]));
  await expect(page.getByRole("alert")).toHaveCount(0);
  await expect.poll(async () => (await stateOf(page)).panorama).toBe("night.hdr");
  const other = await page.context().newPage();
  await other.goto(page.url());
  await expect(other.getByRole("alert")).toContainText(told);
  await other.close();
});

/** Drop a bumpy sheet of 2 n^2 triangles on the page, as a .obj file that is made there. */
async function dropSheet(page: Page, name: string, n: number): Promise<void> {
  await page.evaluate(
    ([name, n]) => {
      const lines: string[] = [];
      for (let row = 0; row <= n; row++)
        for (let column = 0; column <= n; column++)
          lines.push(`v ${column} ${Math.sin(row + column)} ${row}`);
      for (let row = 0; row < n; row++)
        for (let column = 0; column < n; column++) {
          const first = row * (n + 1) + column + 1;
          lines.push(`f ${first} ${first + n + 1} ${first + n + 2} ${first + 1}`);
        }
      const dataTransfer = new DataTransfer();
      dataTransfer.items.add(new File([lines.join("\n")], name));
      Object.assign(window, { turns: 0 });
      setInterval(() => Object(window).turns++, 10);
      setTimeout(() =>
        document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true })),
      );
    },
    [name, n] as const,
  );
}

test("a large mesh is read beside the page, and can be cancelled", async ({ page }) => {
  await open(page);
  const object = page.getByRole("combobox", { name: "Object" });
  await dropSheet(page, "sheet.obj", 200); // 80,000 triangles
  await expect(object).toHaveValue("own");
  // Read by the page itself, it would have had a turn before, and one behind.
  expect(await page.evaluate(() => Object(window).turns)).toBeGreaterThan(8);
  await give(page, "huge.ply", "ply\nformat ascii 1.0\nelement face 2500000\nend_header\n");
  await expect(page.getByRole("alert")).toContainText("more than a million triangles");
  await page.getByRole("button", { name: "Close" }).click();
  await page.evaluate(() => {
    const post = Worker.prototype.postMessage;
    Worker.prototype.postMessage = function (this: Worker, message, options) {
      // This mesh is never read to its end.
      if (message.name !== "readMesh")
        post.call(this, message, options as StructuredSerializeOptions);
    } as typeof post;
  });
  await dropSheet(page, "cancelled.obj", 2);
  await page.getByRole("button", { name: "Cancel" }).click();
  await expect(page.locator(".status")).not.toContainText("Reading");
  await expect(object).toContainText("sheet.obj");
  await expect(page.getByRole("alert")).toHaveCount(0);
});

test("two files are opened together, and a folder and a missing clipboard are told", async ({
  page,
  context,
}) => {
  await page.addInitScript(() =>
    Object.defineProperty(navigator, "clipboard", { value: undefined }),
  );
  await open(page);
  const session = await context.newCDPSession(page);
  const drop = async (...files: string[]) => {
    const data = { items: [], files, dragOperationsMask: 1 };
    for (const type of ["dragEnter", "dragOver", "dragOver", "drop"] as const)
      await session.send("Input.dispatchDragEvent", { type, x: 300, y: 300, data });
  };
  const folder = folderOfTest();
  writeFileSync(join(folder, "evening.hdr"), panorama(64, 32, [128, 64, 32, 129]));
  writeFileSync(
    join(folder, "state.json"),
    JSON.stringify({ materials: [{ bottom: { kind: "diffuse" } }] }),
  );
  await drop(join(folder, "state.json"), join(folder, "evening.hdr"));
  await expect(coats(page)).toHaveCount(0);
  await expect(page.getByRole("combobox", { name: "Light" })).toContainText("evening.hdr");
  await expect(page.getByRole("alert")).toHaveCount(0);
  await drop(folder);
  await expect(page.getByRole("alert")).toContainText("It is a folder");
  await page.getByRole("button", { name: "Close" }).press("Enter");
  await expect(page.locator(".stage canvas")).toBeFocused();
  await page.evaluate(() => {
    const dataTransfer = new DataTransfer();
    dataTransfer.setData("text/plain", "hello");
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer, bubbles: true }));
  });
  await expect(page.getByRole("alert")).toContainText("is no file");
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByRole("button", { name: /^Copy the address/ }).click();
  await expect(page.getByRole("alert")).toContainText("copy the address from the address bar");
});

test("what the page begins with is fetched by another try", async ({ page, quiet }) => {
  const patterns = ["**/start.json*", "**/worker.js*", "**/weights.safetensors*"];
  for (const pattern of patterns) await page.route(pattern, (route) => route.abort());
  await page.goto("./");
  for (const pattern of patterns) {
    await expect(page.getByRole("alert")).toContainText("could not be fetched");
    await expect(page.locator(".status")).toHaveText("The networks are not loaded.");
    await page.unroute(pattern);
    await page.getByRole("button", { name: "Try again" }).click();
  }
  await expect(page.locator(".status")).toBeVisible();
  await expect(page.getByRole("alert")).toHaveCount(0);
  quiet.length = 0; // Chromium logs what was not fetched
});

test("what is needed later is fetched by another try", async ({ page, quiet }) => {
  await open(page);
  for (const [pattern, act, done] of [
    [
      "**/anisotropic.safetensors*",
      async () => {
        await page.getByRole("button", { name: "Coat 2, u·v: two widths" }).click();
        await enter(page, "Coat 2, Roughness αᵥ", "0.2");
      },
      (file: string) => page.waitForResponse(file), // and what is saved next has its codes
    ],
    [
      "**/glsl.txt*",
      async () => {
        await page.getByRole("button", { name: "Save", exact: true }).click();
        await page.getByRole("button", { name: "GLSL" }).click();
      },
      () => page.waitForEvent("download"),
    ],
  ] as const) {
    await page.route(pattern, (route) => route.abort());
    await act();
    await expect(page.getByRole("alert")).toContainText("could not be fetched");
    await page.unroute(pattern);
    const finished = done(pattern);
    await page.getByRole("button", { name: "Try again" }).click();
    await finished;
    const missing = page.getByRole("alert").filter({ hasText: "could not be fetched" });
    await expect(missing).toHaveCount(0);
  }
  quiet.length = 0;
});

test("a material with a table is shown by it, by its codes without the file, and coated", async ({
  page,
}) => {
  await open(page);
  const choose = async (from: RegExp, name: string) => {
    await page.getByRole("button", { name: from }).click();
    await page.getByRole("button", { name, exact: true }).click();
  };
  await choose(/^Material Vermilion/, "Anodised niobium, blue");
  await expect(page.locator(".bottom")).toContainText("shown by its table");
  const film = await saved(page, "Material ?safetensors");
  await give(page, "film.safetensors", Buffer.from(film.text, "latin1"));
  await expect(page.getByRole("button", { name: /^Material film/ })).toBeVisible();
  await expect(coats(page)).toHaveCount(0);
  await expect(page.locator(".bottom")).toContainText("film was loaded from a file");
  await choose(/^Material film/, "Black urushi");
  await choose(/^Material Black urushi/, "film");
  await page.getByRole("button", { name: "Add coat" }).click();
  await expect(coats(page)).toHaveCount(1);
  await expect(page.locator(".status")).toBeVisible();
  await expect(page.getByRole("alert")).toHaveCount(0);
  const material = async () => (await stateOf(page)).materials[0];
  await expect.poll(material).toMatchObject({ coats: [{}], bottom: { kind: "codes" } });
  const { bottom } = await material();
  const materials = [{ name: "lost", bottom: { ...bottom, table: "0123abcd" } }];
  await give(page, "state.json", toJson({ materials } as unknown as State));
  await expect(page.getByRole("alert")).toContainText("The table of “lost” is no part of");
});

test("states, descriptions and pictures are saved, and a state is opened again", async ({
  page,
}) => {
  await open(page);
  await enter(page, "Coat 2, Index n", "1.61");
  const state = await saved(page, "State");
  expect(state.name).toBe("vermilion-urushi.json");
  await page.getByRole("button", { name: "Remove Coat 2" }).click();
  await give(page, state.name, state.text);
  await expect(coats(page)).toHaveCount(2);
  await expect(number(page, "Coat 2, Index n")).toHaveValue("1.61");

  const xml = await saved(page, "Mitsuba XML");
  expect(xml.name).toBe("vermilion-urushi.xml");
  expect((await saved(page, "Python")).text).toContain("urushi.diffuse(reflectance=(");
  expect((await saved(page, "Picture")).text.slice(1, 4)).toBe("PNG");
});

test("shader code compiles, and a saved material is opened again and coated", async ({ page }) => {
  await open(page);
  await checkShaders(page);
  const { name, text } = await saved(page, "Material ?safetensors");
  expect(name).toBe("vermilion-urushi.safetensors");
  await give(page, name, Buffer.from(text, "latin1"));
  await expect(coats(page)).toHaveCount(0);
  await expect(page.getByRole("alert")).toHaveCount(0);
  await page.getByRole("button", { name: "Add coat" }).click();
  await expect(coats(page)).toHaveCount(1);
});

async function checkShaders(page: Page): Promise<void> {
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
}

/** What WebGL2 says of functions in GLSL; "" if they compile. */
function compileLog(page: Page, functions: string): Promise<string> {
  const f = "urushi_f(urushi_material(), wi, wo, functions)";
  const main = `uniform highp sampler3D functions; void main() { colour = vec4(${f}, 1.0); }`;
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
