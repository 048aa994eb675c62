/** Textures of codes: decoded at each pixel, as Mitsuba renders them; and what cannot be done. */

import { readFileSync } from "node:fs";
import { join } from "node:path";
import type { Page } from "@playwright/test";
import { nameOf } from "../../src/save/zip";
import { folderOfTest, python } from "../python";
import { expectAlike, hasFlip } from "./compared";
import { addressOf, coats, colourAt, expect, give, open, refined, saved, test } from "./page";

let folder: string;
let texture: Buffer;

test.beforeAll(() => {
  folder = folderOfTest();
  const file = join(folder, "stripes.safetensors");
  python(join(import.meta.dirname, "texture.py"), file);
  texture = readFileSync(file);
});

/** The material of the texture. */
function stripes() {
  return { name: "stripes", bottom: { kind: "texels", texture: nameOf(texture) } };
}

/** Let the page find the texture beside it, and what else it begins with. */
async function beginWithTexture(page: Page, start: object = {}): Promise<void> {
  await page.route("**/start.json*", (route) =>
    route.fulfill({ json: { ...start, texture: "texture.safetensors" } }),
  );
  await page.route("**/texture.safetensors*", (route) => route.fulfill({ body: texture }));
}

const view = { azimuth: 20, elevation: 25, zoom: 1.4 };

test.describe("beside Mitsuba", () => {
  // One canvas pixel for several of the screen: the processor draws.
  test.use({ deviceScaleFactor: 0.12, picture: true });
  test.skip(!hasFlip, "the package flip-evaluator has no wheel for this machine");

  // The sky's sun is a light that is evaluated directly. The mean of the
  // teapot needs all frames; on the ball a third of them has the same mean.
  for (const [object, environment, share] of [
    ["teapot", "studio", 1],
    ["ball", "sky", 1 / 3],
  ] as const)
    test.describe(() => {
      test.use({ refined: share });
      const tag = share === 1 ? "@long" : [];
      test(`${object}, ${environment}: as Mitsuba renders it`, { tag }, async ({ page }) => {
        test.setTimeout(1_200_000);
        await beginWithTexture(page);
        const materials = [stripes()];
        await open(page, addressOf({ materials, object, environment, view, rotation: 30 }));
        await expect(page.getByRole("button", { name: "Material stripes" })).toBeVisible();
        await expect(page.locator(".status")).toHaveText("refining");
        await refined(page, share);
        await expectAlike(page, `texture on a ${object}`);
      });
    });
});

test("a texture is shown, saved as it was, and not coated; one that is damaged or missing is told", async ({
  page,
}) => {
  await open(page);
  await give(page, "stripes.safetensors", texture);
  await expect(page.getByRole("combobox", { name: "Kind of bottom" })).toHaveValue("texels");
  await expect(coats(page)).toHaveCount(0);
  await expect(page.getByRole("button", { name: "Add coat" })).toBeDisabled();
  await expect(page.locator(".status")).toBeVisible();
  const file = await saved(page, "Material ?safetensors");
  expect(Buffer.from(file.text, "latin1").equals(texture)).toBe(true);
  await page.getByRole("button", { name: "Save", exact: true }).click();
  await page.getByRole("button", { name: /^Mitsuba XML/ }).click();
  await expect(page.getByRole("alert")).toContainText("saved as a material file");

  await give(page, "cut.safetensors", texture.subarray(0, texture.length - 9));
  await expect(page.getByRole("alert")).toContainText("does not fit the file");
  const bottom = { kind: "texels", texture: "0123abcd" };
  await give(page, "state.json", JSON.stringify({ materials: [{ name: "silk", bottom }] }));
  await expect(page.getByRole("alert")).toContainText("The texture of “silk” is no part");
});

test.describe("in a picture", () => {
  test.use({ deviceScaleFactor: 0.5, picture: true });

  test("the page begins with a texture beside it", async ({ page }) => {
    await beginWithTexture(page, { materials: [stripes()] });
    await open(page);
    await expect(page.getByRole("button", { name: "Material stripes" })).toBeVisible();
    await expect(page.getByRole("alert")).toHaveCount(0);
    await expect(async () => {
      const colours = await Promise.all(
        [0.42, 0.46, 0.5, 0.54, 0.58].map((x) => colourAt(page, x, 0.6)),
      );
      const blue = colours.map(([red, , blue]) => blue! - red!);
      expect(Math.max(...blue) - Math.min(...blue)).toBeGreaterThan(20);
    }).toPass();
  });
});
