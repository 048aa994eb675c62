/** The picture: it is there, follows the cards, and its absence is told. */

import { decoded } from "../../src/material/colour";
import { colourAt, expect, give, number, open, panorama, test } from "./page";

/** An address of a red matt ball in a small picture, where everything is fast. */
async function matt(page: import("@playwright/test").Page, reflectance: number[]): Promise<void> {
  await page.setViewportSize({ width: 900, height: 420 });
  await open(page);
  await page.getByRole("combobox", { name: "Object" }).selectOption("ball");
  await page.getByRole("button", { name: "Remove Coat 2" }).click();
  await page.getByRole("button", { name: "Remove Coat 1" }).click();
  for (const [at, channel] of ["red", "green", "blue"].entries()) {
    const field = number(page, `Bottom, Reflectance, ${channel}`);
    await field.fill(String(reflectance[at]));
    await field.press("Enter");
  }
}

test("the picture shows the material, and follows it", async ({ page }) => {
  await matt(page, [0.8, 0.1, 0.1]);
  await expect
    .poll(async () => {
      const [red, green] = await colourAt(page, 0.5, 0.4);
      return red! > 1.8 * green!;
    })
    .toBe(true);
  await number(page, "Bottom, Reflectance, red").fill("0.05");
  await number(page, "Bottom, Reflectance, red").press("Enter");
  await expect
    .poll(async () => {
      const [red, green] = await colourAt(page, 0.5, 0.4);
      return red! < green!;
    })
    .toBe(true);
});

test("a brighter exposure is brighter, and the camera turns by the keyboard", async ({ page }) => {
  await matt(page, [0.3, 0.3, 0.3]);
  await expect.poll(async () => (await colourAt(page, 0.5, 0.4))[0]!).toBeGreaterThan(5);
  const [before] = await colourAt(page, 0.5, 0.4);
  await page.getByRole("slider", { name: "Exposure" }).focus();
  for (let step = 0; step < 10; step++) await page.keyboard.press("ArrowRight");
  await expect
    .poll(async () => (await colourAt(page, 0.5, 0.4))[0]!)
    .toBeGreaterThan(1.15 * before!);

  const address = page.url();
  await page.locator(".stage canvas").focus();
  await page.keyboard.press("ArrowRight");
  await expect.poll(() => page.url()).not.toBe(address);
});

test("two materials are compared by a swipe", async ({ page }) => {
  await matt(page, [0.8, 0.1, 0.1]);
  await page.getByRole("button", { name: "Swipe" }).click();
  await page.getByRole("button", { name: /^B / }).click();
  await page.getByLabel("Kind of bottom").selectOption("diffuse");
  const remove = page.getByRole("button", { name: /^Remove/ });
  while ((await remove.count()) > 0) await remove.first().click();
  for (const [channel, value] of Object.entries({ red: "0.1", green: "0.1", blue: "0.8" })) {
    const field = number(page, `Bottom, Reflectance, ${channel}`);
    await field.fill(value);
    await field.press("Enter");
  }
  const edge = page.getByRole("slider", { name: "Edge between A and B" });
  await expect(edge).toHaveAttribute("aria-valuenow", "50");
  await expect
    .poll(async () => {
      const left = await colourAt(page, 0.45, 0.4);
      const right = await colourAt(page, 0.55, 0.4);
      return left[0]! > left[2]! && right[2]! > right[0]!;
    })
    .toBe(true);
  await edge.focus();
  for (let step = 0; step < 8; step++) await page.keyboard.press("ArrowRight");
  await expect(edge).toHaveAttribute("aria-valuenow", "66");
  await expect
    .poll(async () => {
      const middle = await colourAt(page, 0.55, 0.4);
      return middle[0]! > middle[2]!;
    })
    .toBe(true);
});

test("the difference of two materials is dark where they agree", async ({ page }) => {
  await matt(page, [0.3, 0.3, 0.3]);
  await page.getByRole("button", { name: "Difference" }).click();
  await page.getByRole("button", { name: /^B / }).click();
  await page.getByLabel("Kind of bottom").selectOption("diffuse");
  const remove = page.getByRole("button", { name: /^Remove/ });
  while ((await remove.count()) > 0) await remove.first().click();
  const reflectance = async (values: number[]) => {
    for (const [at, channel] of ["red", "green", "blue"].entries()) {
      const field = number(page, `Bottom, Reflectance, ${channel}`);
      if ((await field.count()) === 0)
        await page.getByRole("button", { name: /^Bottom, Reflectance: one value/ }).click();
      await field.fill(String(values[at]));
      await field.press("Enter");
    }
  };
  const sum = async () => (await colourAt(page, 0.5, 0.4)).reduce((a, b) => a + b);
  await page.getByLabel("Largest difference").selectOption("10");
  await reflectance([0.3, 0.3, 0.3]);
  await expect.poll(sum).toBeLessThan(12);
  // The same lightness in another colour is a difference, too.
  await reflectance([0.3, 0.32, 0.18]);
  await expect.poll(sum).toBeGreaterThan(300);
  const before = await sum();
  await page.getByLabel("Largest difference").selectOption("50");
  await expect.poll(sum).toBeLessThan(before - 50);
});

/** Radiance of a shown colour below 0.7: sRGB and the neutral tone curve undone. */
function radiance(shown: number[]): number[] {
  const toned = shown.map((value) => decoded(value / 255));
  const least = Math.min(...toned);
  const offset = least >= 0.04 ? 0.04 : Math.sqrt(least / 6.25) - least;
  return toned.map((value) => value + offset);
}

test("in an even light the picture is the directional albedo", async ({ page }) => {
  await page.setViewportSize({ width: 900, height: 420 });
  await open(page);
  await page.getByRole("button", { name: /choose another/ }).click();
  await page.getByRole("button", { name: "Gold maki-e" }).click();
  await page.getByRole("combobox", { name: "Object" }).selectOption("ball");
  await give(page, "even.hdr", panorama(64, 32, [64, 64, 64, 129])); // radiance 0.5
  const label = page.getByRole("img", { name: /^Directional albedo in percent/ });
  await expect(label).toHaveAttribute("aria-label", /: (?!NaN)\d+, \d+, \d+ near the normal/);
  const albedo = async () => {
    const text = (await label.getAttribute("aria-label"))!;
    return /: (\d+), (\d+), (\d+) near/
      .exec(text)!
      .slice(1)
      .map((x) => Number(x) / 100);
  };
  // The quadrature of few directions is within two percent of the light.
  await expect
    .poll(async () => {
      const shown = radiance(await colourAt(page, 0.5, 0.5));
      const known = await albedo();
      return Math.max(...known.map((x, k) => Math.abs(shown[k]! / 0.5 - x)));
    })
    .toBeLessThan(0.02);
});

test("a lost context is told, and the picture returns", async ({ page }) => {
  await page.setViewportSize({ width: 900, height: 420 });
  await open(page);
  await page.locator(".stage canvas").evaluate((element) => {
    const gl = (element as HTMLCanvasElement).getContext("webgl2")!;
    const extension = gl.getExtension("WEBGL_lose_context")!;
    extension.loseContext();
    setTimeout(() => extension.restoreContext(), 1500);
  });
  await expect(page.getByText("The graphics driver has taken the picture away")).toBeVisible();
  await expect(page.getByText("The graphics driver has taken the picture away")).toHaveCount(0);
  await expect.poll(async () => Math.max(...(await colourAt(page, 0.5, 0.5)))).toBeGreaterThan(5);
});

test("without WebGL 2 a sentence says so, and the cards work", async ({ page }) => {
  await page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string) {
      return kind === "webgl2" ? null : original.call(this, kind as "2d");
    } as typeof original;
  });
  await page.goto("./");
  await expect(page.getByText("This browser offers no WebGL 2")).toBeVisible();
  await page.getByRole("button", { name: "Remove Coat 2" }).click();
  await expect(page.locator(".curve").first()).toBeVisible();
});
