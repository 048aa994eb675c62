/** The page for everybody: axe finds nothing against WCAG 2.2 AA, and the keyboard reaches all. */

import AxeBuilder from "@axe-core/playwright";
import { expect, open, test } from "./page";

const TAGS = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"];

/** Rules that axe leaves out by itself. */
const RULES = ["label-content-name-mismatch", "target-size"];

for (const [colorScheme, forcedColors] of [
  ["light", "none"],
  ["dark", "none"],
  ["light", "active"],
  ["dark", "active"],
] as const)
  test(`axe finds nothing: ${colorScheme}, forced colours: ${forcedColors}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme, forcedColors });
    await open(page);
    const check = async (width: number, height: number) => {
      await page.setViewportSize({ width, height });
      const builder = new AxeBuilder({ page }).withTags(TAGS);
      const rules = Object.fromEntries(RULES.map((rule) => [rule, { enabled: true }]));
      const { violations } = await builder.options({ rules }).analyze();
      const found = violations.map(({ id, nodes }) => [id, nodes[0]!.html]);
      expect(found, `${width} by ${height}`).toEqual([]);
    };
    const button = (name: string) => page.getByRole("button", { name, exact: true });
    await check(360, 800);
    await check(1600, 900);
    await button("Swipe").click();
    await button("Coat 2, u·v: two widths").click();
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
    "Save",
    "Solo Coat 2",
    "Coat 1, Index n",
    "Angle of incidence",
  ])
    expect([...reached]).toContain(name);
});
