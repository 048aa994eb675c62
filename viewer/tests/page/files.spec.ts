/** Opening and saving: good files, bad files, and what is written is read again. */

import { readFileSync } from "node:fs";
import type { Page } from "@playwright/test";
import { coats, expect, give, number, open, panorama, test } from "./page";

async function saved(page: Page, label: string): Promise<{ name: string; text: string }> {
  await page.getByRole("button", { name: "Save", exact: true }).click();
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: new RegExp(`^${label}`) }).click();
  const file = await download;
  return { name: file.suggestedFilename(), text: readFileSync(await file.path(), "latin1") };
}

for (const [name, content, sentence] of [
  ["notes.txt", "hello", "The page opens materials"],
  ["broken.safetensors", "hello", "damaged or no material"],
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
