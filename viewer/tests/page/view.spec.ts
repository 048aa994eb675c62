/** The stage: pan, field of view, turntable, full screen, folded plots, and names. */

import { INITIAL } from "../../src/state/state";
import { addressOf, expect, open, saved, stateOf, test } from "./page";

const view = async (page: import("@playwright/test").Page) => (await stateOf(page)).view;

test("the camera is moved by pointer, keyboard and menu; its turntable heeds a wish for less motion", async ({
  page,
}) => {
  await open(page);
  const canvas = page.locator(".stage canvas");
  const box = (await canvas.boundingBox())!;
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down({ button: "right" });
  await page.mouse.move(x + box.height / 4, y - box.height / 8, { steps: 5 });
  await page.mouse.up({ button: "right" });
  // By half heights of the picture
  await expect.poll(async () => (await view(page)).pan[0]).toBeCloseTo(0.5, 1);
  expect((await view(page)).pan[1]).toBeCloseTo(0.25, 1);
  await page.keyboard.press("Control+="); // the browser's, as is the next
  await page.keyboard.press("Alt+ArrowRight");
  await page.keyboard.press("Control+ArrowLeft");
  await expect.poll(async () => (await view(page)).pan[0]).toBeCloseTo(0.4, 1);
  expect(await view(page)).toMatchObject({ azimuth: 20, zoom: 1 });

  await page.getByRole("button", { name: "View", exact: true }).click();
  await page.getByRole("slider", { name: "Field of view" }).press("ArrowRight");
  await expect.poll(async () => (await view(page)).fov).toBe(25);
  await page.getByRole("button", { name: "Reset camera" }).click();
  await expect.poll(async () => await view(page)).toMatchObject({ fov: 24, pan: [0, 0] });

  const turntable = page.getByLabel("Turntable");
  await turntable.check();
  const azimuth = async () => (await view(page)).azimuth;
  await expect.poll(azimuth).toBeGreaterThan(21);
  const before = await azimuth();
  await expect.poll(azimuth).toBeGreaterThan(before + 1);
  await page.emulateMedia({ reducedMotion: "reduce" });
  await expect(turntable).not.toBeChecked();
  await expect.poll(async () => (await stateOf(page)).turntable).toBe(false);
  const last = await azimuth();
  await page.locator(".stage canvas").press("ArrowRight"); // turns it by 5 degrees, and nothing else does
  await expect.poll(azimuth).toBeCloseTo(last + 5, 3);
});

test("a zoom keeps a camera that stands as high as a state permits", async ({ page }) => {
  await open(page, addressOf({ ...INITIAL, view: { ...INITIAL.view, elevation: 85 } }));
  await page.locator(".stage canvas").press("+");
  await expect.poll(async () => await view(page)).toMatchObject({ zoom: 1.1, elevation: 85 });
});

test("the picture fills the screen, plots fold away, and a material has another name", async ({
  page,
}) => {
  await page.goto("./");
  const plots = page.locator(".plots summary");
  const angle = page.getByRole("slider", { name: "Angle of incidence" });
  await expect(angle).toBeHidden(); // as everywhere at first
  const height = async () => (await page.locator(".stage").boundingBox())!.height;
  const before = await height();
  await plots.click();
  await expect(angle).toBeInViewport();
  expect(await height()).toBe(before); // the picture keeps its place
  await expect.poll(async () => (await stateOf(page)).plots).toBe(true);
  await angle.press("End");
  await expect(angle).toHaveAttribute("aria-valuenow", "89");
  await angle.press("Home");
  await expect(angle).toHaveAttribute("aria-valuenow", "0");
  await plots.click();
  await page.getByLabel("Name of the material").fill("Tray 7");
  await page.keyboard.press("Enter");
  await expect(page.getByRole("button", { name: /^Material Tray 7: choose/ })).toBeVisible();
  expect((await saved(page, "State")).name).toBe("tray-7.json");
  await page.getByRole("button", { name: "Undo" }).click();
  await expect(page.getByLabel("Name of the material")).toHaveValue("Vermilion urushi");
  await expect.poll(async () => (await stateOf(page)).plots).toBe(false);
  await page.reload();
  await expect(page.getByRole("slider", { name: "Angle of incidence" })).toBeHidden();

  await page.getByRole("button", { name: "View", exact: true }).click();
  await page.getByRole("button", { name: "Full screen" }).click();
  await expect.poll(() => page.evaluate(() => document.fullscreenElement?.id)).toBe("stage");
});
