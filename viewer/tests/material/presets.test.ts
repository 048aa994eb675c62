import { expect, test } from "vitest";
import { groupOf, METALS, PRESETS, preset } from "../../src/material/presets";

test("every material of the library has a heading and a name of its own", () => {
  expect(PRESETS.filter((one) => groupOf(one) === "").map(({ name }) => name)).toEqual([]);
  expect(new Set(PRESETS.map(({ name }) => name)).size).toBe(PRESETS.length);
});

test("gold, silver, chrome, black and white are plain", () => {
  const plain = PRESETS.filter((one) => groupOf(one) === "Plain").map(({ name }) => name);
  expect(plain).toEqual(["Gold", "Silver", "Chrome", "Black", "White"]);
  expect(preset("Gold").bottom).toMatchObject(METALS.Gold!);
});
