import { expect, test } from "vitest";
import { groupOf, METALS, PRESETS, preset, titleOf } from "../../src/material/presets";
import { readMaterial } from "../../src/state/read";

test("every material of the library has a heading and a name of its own", () => {
  expect(PRESETS.filter((one) => groupOf(one) === "").map(({ name }) => name)).toEqual([]);
  expect(new Set(PRESETS.map(({ name }) => name)).size).toBe(PRESETS.length);
});

test("gold, silver, chrome, black and white are plain", () => {
  const plain = PRESETS.filter((one) => groupOf(one) === "Plain").map(({ name }) => name);
  expect(plain).toEqual(["Gold", "Silver", "Chrome", "Black", "White"]);
  expect(preset("Gold").bottom).toMatchObject(METALS.Gold!);
});

test("a material that is read again is modified only where a value was changed", () => {
  for (const one of PRESETS) {
    const read = readMaterial(JSON.parse(JSON.stringify(one)));
    expect(titleOf(read)).toBe(one.name);
    expect(titleOf({ ...read, energyCompensation: false })).toBe(
      one.energyCompensation ? `${one.name} (modified)` : one.name,
    );
  }
  const [coat, ...others] = preset("Celadon").coats;
  const changed = { ...preset("Celadon"), coats: [{ ...coat!, on: false }, ...others] };
  expect(titleOf(changed)).toBe("Celadon (modified)");
});
