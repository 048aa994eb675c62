/** The page for everybody: axe finds nothing, light and dark, wide and narrow. */

import AxeBuilder from "@axe-core/playwright";
import { expect, open, test } from "./page";

for (const colorScheme of ["light", "dark"] as const)
  for (const width of [360, 900, 1400])
    test(`axe finds nothing: ${colorScheme}, ${width} pixels wide`, async ({ page }) => {
      await page.emulateMedia({ colorScheme });
      await page.setViewportSize({ width, height: 640 });
      await open(page);
      const violations = async () => {
        const results = await new AxeBuilder({ page }).analyze();
        return results.violations.map(({ id, nodes }) => [id, nodes[0]!.html]);
      };
      expect(await violations()).toEqual([]);
      for (const way of ["Swipe", "Difference"]) {
        await page.getByRole("button", { name: way }).click();
        expect(await violations()).toEqual([]);
      }
      await page.getByRole("button", { name: "Save", exact: true }).click();
      expect(await violations()).toEqual([]);
    });

test("nothing is wider than a narrow window", async ({ page }) => {
  await page.setViewportSize({ width: 360, height: 640 });
  await open(page);
  const widths = await page.evaluate(() => [
    document.documentElement.scrollWidth,
    document.documentElement.clientWidth,
  ]);
  expect(widths[0]).toBe(widths[1]);
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
  for (const name of ["Save", "Solo Coat 2", "Coat 1, Index η", "Angle of incidence"])
    expect([...reached]).toContain(name);
});
