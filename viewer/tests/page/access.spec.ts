/** The page for everybody: axe finds nothing against WCAG 2.2 AA, and the keyboard reaches all. */

import AxeBuilder from "@axe-core/playwright";
import { expect, open, test } from "./page";

const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** Rules that axe leaves out by itself. */
const RULES = ["label-content-name-mismatch", "target-size"];

/** Light and dark, each as it is and in forced colours. */
const MEDIA = (["none", "active"] as const).flatMap((forcedColors) =>
  (["light", "dark"] as const).map((colorScheme) => ({ colorScheme, forcedColors })),
);

/** Rules that colours decide: only these are asked again of further media. */
const COLOURS = ["color-contrast", "link-in-text-block"];

test("axe finds nothing", async ({ page }) => {
  await open(page);
  const check = async (width: number, height: number) => {
    await page.setViewportSize({ width, height });
    for (const [place, media] of MEDIA.entries()) {
      await page.emulateMedia(media);
      const rules = Object.fromEntries(RULES.map((rule) => [rule, { enabled: true }]));
      const builder = new AxeBuilder({ page }).setLegacyMode(); // as the page has no frames
      if (place === 0) builder.withTags(TAGS).options({ rules });
      else builder.withRules(COLOURS);
      const { violations } = await builder.analyze();
      const found = violations.map(({ id, nodes }) => [id, nodes[0]!.html]);
      expect(found, `${width} by ${height}, ${JSON.stringify(media)}`).toEqual([]);
    }
  };
  const button = (name: string) => page.getByRole("button", { name, exact: true });
  await check(360, 800);
  await check(1600, 900);
  await button("Swipe").click();
  await button("Coat 2, u·v: two widths").click();
  await button("View").click();
  await page.getByRole("combobox", { name: "Background" }).selectOption("colour");
  await check(844, 390);
  await button("Difference").click();
  await button("Save").click();
  await check(1024, 768);
  await page.getByRole("button", { name: /choose another/ }).click();
  await check(390, 844);
});

test("every control is reached by the keyboard", async ({ page }) => {
  await open(page);
  const reached = new Set<string>();
  for (let step = 0; step < 120; step++) {
    await page.keyboard.press("Tab");
    reached.add(
      await page.evaluate(() => {
        const element = document.activeElement!;
        return element.getAttribute("aria-label") ?? element.textContent ?? "";
      }),
    );
  }
  for (const name of [
    "Skip to the layers",
    "View",
    "Save",
    "Name of the material",
    "Plots",
    "Solo Coat 2",
    "Coat 1, Index n",
    "Angle of incidence",
  ])
    expect([...reached]).toContain(name);
});
