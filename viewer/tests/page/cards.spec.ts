/** The cards: sliders and numbers, adding, moving and removing coats, undo, and the address. */

import {
  coats,
  enter,
  expect,
  give,
  number,
  open,
  panorama,
  reset,
  stateOf,
  test,
  unfold,
} from "./page";

test("a slider moves by mouse and keyboard, its number is typed, a double click resets", async ({
  page,
}) => {
  await open(page);
  const slider = page.getByRole("slider", { name: "Coat 2, Roughness α" });
  const field = number(page, "Coat 2, Roughness α");
  const value = async () => Number(await field.inputValue());
  const before = await value();
  await slider.scrollIntoViewIfNeeded();
  const box = (await slider.boundingBox())!;
  await page.mouse.move(box.x + 4, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + 0.8 * box.width, box.y + box.height / 2, { steps: 5 });
  await page.mouse.up();
  await expect.poll(value).toBeGreaterThan(before + 0.5); // the last place of the pointer
  const dragged = await value();

  await slider.focus();
  await page.keyboard.press("ArrowLeft");
  await expect.poll(value).toBeLessThan(dragged);
  await page.keyboard.press("Home");
  await expect(field).toHaveValue("0.01");
  await page.keyboard.press("ArrowRight"); // steps of the same rounded value are one
  await expect(field).toHaveValue("0.0101");
  await enter(page, "Coat 2, Gloss", 0.5);
  await page.getByRole("slider", { name: "Coat 2, Gloss" }).press("ArrowRight");
  await expect(number(page, "Coat 2, Gloss")).toHaveValue("0.502");

  const direction = number(page, "Coat 2, Direction g");
  await enter(page, "Coat 2, Direction g", -0.5);
  await direction.press("ArrowUp");
  await expect(direction).toHaveValue("-0.49");
  const index = number(page, "Coat 2, Index n");
  for (const [typed, shown] of [
    ["1.4", "1.4"],
    ["77", "3"],
    ["glass", "3"],
  ] as const) {
    await enter(page, "Coat 2, Index n", typed);
    await expect(index).toHaveValue(shown);
  }
  await index.press("ArrowDown");
  await expect(index).toHaveValue("2.9");
  await page.getByRole("slider", { name: "Coat 2, Index n" }).dblclick();
  await expect(index).toHaveValue("1.5");
});

test("a coat's medium has an appearance, a physics and one colour", async ({ page }) => {
  await open(page);
  await enter(page, "Coat 2, Colour, blue", "0.25");
  await expect(number(page, "Coat 2, Depth σₜ, blue")).toHaveValue(/^0\.693/); // -ln(0.25) / 2
  await enter(page, "Coat 2, Thickness", "2");
  await page.getByLabel("Energy compensation").check();
  await expect
    .poll(async () => (await stateOf(page)).materials[0])
    .toMatchObject({
      coats: [{ color: [0.85, 0.65, 0.25], body: 0, thickness: 2 }, { body: 1 }],
      energyCompensation: true,
    });
  await expect(page.getByRole("button", { name: /choose another/ })).toContainText("(modified)");

  await reset(page);
  const coat = async (place: number) => (await stateOf(page)).materials[0].coats[place];
  await page.getByLabel("Coat 2, Colour: choose", { exact: true }).fill("#ff0000");
  await expect.poll(() => coat(0)).toMatchObject({ color: [1, 0, 0], body: 0 });
  // A clear coat that becomes a paint keeps its colour, which the pigment has then.
  await enter(page, "Coat 2, Opacity", 1);
  await expect.poll(() => coat(0)).toMatchObject({ color: 1, body: 1, bodyColor: [1, 0, 0] });
  await enter(page, "Coat 2, Gloss", 0);
  await expect(number(page, "Coat 2, Roughness α")).toHaveValue("1");

  await reset(page);
  const split = page.getByRole("button", { name: "Coat 2, Scattering: one value for each colour" });
  await split.click();
  await enter(page, "Coat 2, Scattering, green", "0.6");
  await expect(number(page, "Coat 2, Scattering, red")).toHaveValue("0");
  await split.click();
  await expect(number(page, "Coat 2, Scattering")).toHaveValue("0.2");
});

test("a coat is added, moved by mouse and keyboard, removed, and brought back", async ({
  page,
}) => {
  await page.setViewportSize({ width: 900, height: 1200 }); // what is dragged stays in sight
  await open(page);
  await expect(coats(page)).toHaveCount(2);
  await page.getByRole("button", { name: "Add coat" }).click();
  await expect(coats(page)).toHaveCount(3);
  const thickness = (coat: number) => number(page, `Coat ${coat}, Thickness`);
  await enter(page, "Coat 3, Thickness", 2);

  await page.getByRole("button", { name: /^Move Coat 3/ }).focus();
  await page.keyboard.press("ArrowDown");
  await expect(thickness(2)).toHaveValue("2");
  await expect(page.getByRole("button", { name: /^Move Coat 2/ })).toBeFocused();

  const from = (await page.getByRole("button", { name: /^Move Coat 2/ }).boundingBox())!;
  const top = (await coats(page).first().boundingBox())!;
  await page.mouse.move(from.x + 8, from.y + 8);
  await page.mouse.down();
  await page.mouse.move(from.x + 8, top.y + 4, { steps: 12 });
  await page.mouse.up();
  await expect(thickness(3)).toHaveValue("2");

  await page.getByRole("button", { name: "Remove Coat 3" }).click();
  await expect(coats(page)).toHaveCount(2);
  await expect(thickness(2)).toHaveValue("1");

  await page.getByRole("button", { name: "Undo" }).click();
  await expect(coats(page)).toHaveCount(3);
  await page.keyboard.press("Control+z");
  await expect(thickness(2)).toHaveValue("2");
  await page.keyboard.press("Control+Shift+z");
  await expect(thickness(3)).toHaveValue("2");
});

test("added coats have the topmost surface", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Add coat" }).click();
  await unfold(page);
  await expect(number(page, "Coat 3, Index n")).toHaveValue("1.53");
  await expect(number(page, "Coat 3, Roughness α")).toHaveValue("0.02");
  // The surface is now that of the added coat: the one below has none, and nothing that does nothing.
  await expect(coats(page).nth(1)).toContainText("no surface, tinted");
  await expect(number(page, "Coat 2, Roughness α")).toHaveCount(0);
  await enter(page, "Coat 2, Index n", "1.7");
  await expect(coats(page).nth(1)).toContainText("glossy, tinted");
  await expect(number(page, "Coat 2, Roughness α")).toHaveValue("0.02");
});

test("what becomes a metal is bright, and what is shown otherwise is said", async ({ page }) => {
  await open(page);
  await expect(coats(page).nth(1)).toContainText("looks alike is shown, of depth 12"); // opaque
  await enter(page, "Coat 1, Opacity", "0.5");
  await expect(coats(page).nth(1)).not.toContainText("looks alike");
  await page.getByLabel("Kind of bottom").selectOption("Metal by reflectance");
  await unfold(page);
  await expect(number(page, "Bottom, Reflectance, red")).toHaveValue("0.9");
  const given = page.getByLabel("Energy compensation");
  await expect(given).toBeEnabled();
  await page.getByRole("button", { name: "Solo the bottom" }).click(); // a bare metal has it
  await expect(given).toBeEnabled();
  await page.getByLabel("Kind of bottom").selectOption("Matt (Lambertian)");
  await expect(given).toBeDisabled();
  await page.getByLabel("Kind of bottom").selectOption("Metal by reflectance");
  await page.getByRole("button", { name: "Solo the bottom" }).click();

  const solo = page.getByRole("button", { name: "Solo Coat 1" });
  const background = () => solo.evaluate((element) => getComputedStyle(element).backgroundColor);
  await solo.click(); // it looks on while the pointer rests on it
  const under = await background();
  await page.mouse.move(5, 5);
  await expect.poll(background).toBe(under);
  await solo.click();
  await page.mouse.move(5, 5);
  await expect.poll(background).not.toBe(under);
});

test("at most six coats, and the focus stays where coats are added and removed", async ({
  page,
}) => {
  await open(page);
  const add = page.getByRole("button", { name: "Add coat" });
  await add.focus();
  for (let count = 3; count <= 7; count++) {
    await page.keyboard.press("Enter");
    await expect(coats(page)).toHaveCount(Math.min(count, 6));
  }
  await expect(add).toBeDisabled();
  await expect(add).toBeFocused();
  await page.getByRole("button", { name: "Remove Coat 3" }).focus();
  for (const next of ["Remove Coat 2", "Remove Coat 1", "Remove Coat 1", "Remove Coat 1"]) {
    await page.keyboard.press("Enter");
    await expect(page.getByRole("button", { name: next })).toBeFocused();
  }
  for (let count = 1; count >= 0; count--) {
    await page.keyboard.press("Enter");
    await expect(coats(page)).toHaveCount(count);
  }
  await expect(add).toBeFocused();
  await page.getByRole("button", { name: "Undo" }).focus();
  for (let step = 0; step < 11; step++) await page.keyboard.press("Enter");
  await expect(page.getByRole("button", { name: "Undo" })).toBeDisabled();
  await expect(page.getByRole("button", { name: "Undo" })).toBeFocused();
});

test("an undo takes back one action, and in a number the number", async ({ page }) => {
  await open(page);
  await page.getByRole("slider", { name: "Coat 2, Index n" }).press("ArrowRight");
  await page.locator(".stage canvas").press("Shift+ArrowRight");
  await give(page, "first.hdr", panorama(64, 32, [128, 64, 32, 129]));
  const lamp = page.getByRole("combobox", { name: "Light" });
  await expect(lamp).toHaveValue("own");
  await give(page, "second.hdr", panorama(64, 32, [32, 64, 128, 129]));
  await expect(lamp).toContainText("second.hdr");
  await expect.poll(async () => (await stateOf(page)).panorama).toBe("second.hdr");
  const after = await stateOf(page);
  const seen = async () => {
    const { environment, panorama, rotation, materials } = await stateOf(page);
    return [environment, panorama, rotation, materials[0].coats[0].ior === 1.53];
  };
  for (const left of [
    ["own", "first.hdr", 5, false],
    ["studio", "", 5, false],
    ["studio", "", 0, false],
    ["studio", "", 0, true],
  ]) {
    await page.keyboard.press("Control+z");
    await expect.poll(seen).toEqual(left);
  }
  for (let step = 0; step < 4; step++) await page.keyboard.press("Control+Shift+z");
  await expect.poll(() => stateOf(page)).toEqual(after);

  await reset(page);
  await page.getByRole("button", { name: "Remove Coat 1" }).click();
  const field = number(page, "Coat 1, Index n");
  await field.click();
  await page.keyboard.type("1.8");
  await page.keyboard.press("Control+z");
  await expect(field).toHaveValue("1.53");
  await expect(coats(page)).toHaveCount(1);
  await field.selectText();
  await page.keyboard.type("1.7");
  await page.keyboard.press("Enter");
  const ior = async () => (await stateOf(page)).materials[0].coats[0].ior;
  await expect.poll(ior).toBe(1.7);
  await page.keyboard.press("Control+z");
  await expect.poll(ior).toBe(1.53);
  await expect(coats(page)).toHaveCount(1);
});

test("two widths have sliders and an angle, and the address holds the state; a damaged one is told", async ({
  page,
}) => {
  await open(page);
  const link = page.getByRole("button", { name: "Bottom, u·v: two widths" });
  await page.getByLabel("Kind of bottom").selectOption("Metal by reflectance");
  await unfold(page);
  await expect(number(page, "Material, Tangent angle")).toHaveCount(0);
  await link.click();
  await expect(link).toHaveAttribute("aria-pressed", "true");
  await enter(page, "Bottom, Roughness αᵥ", 0.6);
  const angle = number(page, "Material, Tangent angle");
  await enter(page, "Material, Tangent angle", 45);
  await expect(angle).toHaveValue("45");
  await page.getByRole("combobox", { name: "Object" }).selectOption("plate");
  // The address follows with a delay.
  await expect.poll(async () => (await stateOf(page)).object).toBe("plate");
  await expect(page.getByRole("alert")).toHaveCount(0);
  const other = await page.context().newPage();
  await other.goto(page.url());
  await unfold(other);
  await expect(number(other, "Bottom, Roughness αᵥ")).toHaveValue("0.6");
  await expect(number(other, "Material, Tangent angle")).toHaveValue("45");
  await expect(other.getByRole("combobox", { name: "Object" })).toHaveValue("plate");
  await other.close();
  await page.getByRole("button", { name: "Undo" }).click();
  await link.click();
  await expect(angle).toHaveCount(0);
  await page.getByRole("button", { name: "Undo" }).click();
  await expect(angle).toHaveValue("45");

  await page.goto("./#u2.abc.eyJtYXRlcmlhbHMi");
  await expect(page.getByRole("alert")).toContainText("The address is incomplete");
  await page.getByRole("button", { name: "Close" }).click();
  await page.evaluate(() => {
    location.hash = ""; // an address that says nothing
  });
  await expect(page.getByRole("alert")).toHaveCount(0);
  await expect(angle).toHaveValue("45");
});
