import { expect, test } from "vitest";
import { entersLower } from "../../src/material/material";
import { groupOf, METALS, PRESETS, preset } from "../../src/material/presets";

test("every material of the library has a heading and a name of its own", () => {
  expect(PRESETS.filter((one) => groupOf(one) === "").map(({ name }) => name)).toEqual([]);
  expect(new Set(PRESETS.map(({ name }) => name)).size).toBe(PRESETS.length);
});

test("no material of the library enters a lower index, and glass over air does", () => {
  expect(PRESETS.filter(entersLower)).toEqual([]);
  const { coats, ...paint } = preset("White");
  const air = { ...coats[0]!, ior: 1.000277, id: 2 };
  expect(entersLower({ ...paint, coats: [...coats, air] })).toBe(true);
});

test("gold, silver, chrome, black and white are plain", () => {
  const plain = PRESETS.filter((one) => groupOf(one) === "Plain").map(({ name }) => name);
  expect(plain).toEqual(["Gold", "Silver", "Chrome", "Black", "White"]);
  expect(preset("Gold").bottom).toMatchObject(METALS.Gold!);
});
