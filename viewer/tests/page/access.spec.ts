/** The page for everybody: axe finds nothing against WCAG 2.2 AA, and the keyboard reaches all. */

import AxeBuilder from "@axe-core/playwright";
import { expect, number, open, test } from "./page";

const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** Rules that axe leaves out by itself. */
const RULES = ["label-content-name-mismatch", "target-size"];

/** Light, dark, and in forced colours. */
const MEDIA = [
  { colorScheme: "light", forcedColors: "none" },
  { colorScheme: "dark", forcedColors: "none" },
  { colorScheme: "dark", forcedColors: "active" },
] as const;

/** Rules that colours decide: only these are asked again of further media. */
const COLOURS = ["color-contrast", "link-in-text-block"];

test("axe finds nothing", async ({ page }) => {
  await open(page);
  const check = async (
    width: number,
    height: number,
    media: readonly (typeof MEDIA)[number][] = MEDIA.slice(0, 1),
  ) => {
    await page.setViewportSize({ width, height });
    for (const [place, medium] of media.entries()) {
      await page.emulateMedia(medium);
      const rules = Object.fromEntries(RULES.map((rule) => [rule, { enabled: true }]));
      const builder = new AxeBuilder({ page }).setLegacyMode(); // as the page has no frames
      if (place === 0) builder.withTags(TAGS).options({ rules });
      else builder.withRules(COLOURS);
      const { violations } = await builder.analyze();
      const found = violations.map(({ id, nodes }) => [id, nodes[0].html]);
      expect(found, `${width} by ${height}, ${JSON.stringify(medium)}`).toEqual([]);
    }
  };
  const button = (name: string) => page.getByRole("button", { name, exact: true });
  await check(360, 800);
  await check(1600, 900, MEDIA);
  await button("Swipe").click();
  await button("Coat 2, u·v: two widths").click();
  await button("View").click();
  await page.getByRole("combobox", { name: "Background" }).selectOption("colour");
  await check(844, 390);
  await button("Difference").click();
  await button("Save").click();
  await check(1024, 768, MEDIA);
  await page.getByRole("button", { name: /choose another/ }).click();
  await check(390, 844);
});

test("every control is reached by the keyboard, and news are spoken once", async ({ page }) => {
  await open(page);
  const left = new Set([
    "Skip to the layers",
    "View",
    "Save",
    "Name of the material",
    "Plots",
    "Solo Coat 2",
    "Coat 1, Index n",
    "Angle of incidence",
  ]);
  for (let step = 0; step < 200 && left.size > 0; step++) {
    await page.keyboard.press("Tab");
    left.delete(
      await page.evaluate(() => {
        const element = document.activeElement!;
        return element.getAttribute("aria-label") ?? element.textContent ?? "";
      }),
    );
  }
  expect([...left]).toEqual([]);

  await expect(page).toHaveTitle("Vermilion urushi · Urushi");
  await expect(page.locator(".stage canvas")).toHaveAttribute("aria-label", /goblet of Vermilion/);
  const spoken = await page.evaluateHandle(() => {
    const texts: string[] = [];
    const status = document.querySelector(".spoken[role=status]")!;
    const note = () => texts.push(status.textContent!.trim());
    new MutationObserver(note).observe(status, {
      childList: true,
      characterData: true,
      subtree: true,
    });
    return texts;
  });
  const times = () =>
    spoken.evaluate((texts) => texts.filter((text) => text === "Coat 1 was removed.").length);
  await page.getByRole("button", { name: "Remove Coat 1" }).click();
  await expect.poll(times).toBe(1);
  await expect(page).toHaveTitle("Vermilion urushi (modified) · Urushi");
  await expect(page.locator(".spoken[role=status]")).not.toHaveText("Coat 1 was removed.");
  expect(await times()).toBe(1);
});

test("the menu of materials is one stop of the keyboard, with arrows, and a search", async ({
  page,
}) => {
  await open(page);
  const material = (name: string) => page.getByRole("button", { name, exact: true });
  await page.getByRole("button", { name: /choose another/ }).press("Enter");
  await expect(material("Vermilion urushi")).toBeFocused();
  await page.keyboard.press("ArrowLeft");
  await expect(material("Black urushi")).toBeFocused();
  await page.keyboard.press("ArrowUp");
  await expect(material("Gold")).toBeFocused(); // of the group above
  await page.keyboard.press("Tab");
  await expect(page.getByRole("button", { name: "Undo" })).toBeFocused();
  await expect(page.locator(".menu.presets .panel")).toHaveCount(0);

  await page.getByRole("button", { name: /choose another/ }).press("Enter");
  await expect(material("Vermilion urushi")).toBeFocused(); // what is typed then is sought
  await page.keyboard.type("cela");
  await expect(page.getByLabel("Search the materials")).toHaveValue("cela");
  await expect(page.locator(".menu.presets li")).toHaveText(["Celadon"]);
  await page.keyboard.press("Enter");
  await expect(page.getByLabel("Name of the material")).toHaveValue("Celadon");
  await expect(page.locator(".menu.presets .panel")).toHaveCount(0);

  await page.getByRole("button", { name: /choose another/ }).press("Enter");
  await expect(material("Celadon")).toBeFocused();
  await page.keyboard.type("g");
  await page.keyboard.press("Control+z"); // of what was typed
  await page.keyboard.press("Escape");
  await expect(page.getByLabel("Name of the material")).toHaveValue("Celadon");
});

test("tooltips are read by keyboard and touch, type grows, and numbers are not cut off", async ({
  page,
}) => {
  await open(page);
  await page.getByRole("button", { name: "Explain the page" }).click();
  const told = page.locator(".explanation");
  await expect(told).toContainText("Tap, point at or focus");
  await page.getByRole("slider", { name: "Coat 2, Thickness" }).focus();
  await expect(told).toContainText("Factor of the medium's depth");
  await page.locator(".field .label", { hasText: "Opacity" }).first().dispatchEvent("pointerdown");
  await expect(told).toContainText("How opaque the pigment is");
  await page.getByRole("button", { name: "Explain the page" }).click();
  await expect(told).toBeHidden();

  const size = () =>
    page.evaluate(() => Number.parseFloat(getComputedStyle(document.body).fontSize));
  await page.setViewportSize({ width: 1440, height: 900 });
  await expect.poll(size).toBeCloseTo(13, 1);
  await page.setViewportSize({ width: 2560, height: 1300 });
  await expect.poll(size).toBeGreaterThan(15);
  const field = number(page, "Bottom, Reflectance, red");
  await field.fill("0.0813");
  await field.press("Enter");
  for (const [width, height] of [
    [2560, 1300],
    [1024, 768],
    [390, 844],
  ] as const) {
    await page.setViewportSize({ width, height });
    await expect.poll(() => page.evaluate(() => innerWidth)).toBe(width);
    const cut = await page
      .locator("input.number")
      .evaluateAll((all) => all.some((input) => input.scrollWidth > input.clientWidth));
    expect(cut, `${width}`).toBe(false);
  }
  const toolbar = page.locator(".toolbar");
  expect(await toolbar.evaluate((bar) => bar.scrollWidth > bar.clientWidth)).toBe(true);
  await expect(toolbar).toHaveCSS("mask-image", /gradient/);
});
