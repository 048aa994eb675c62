import { expect, test } from "vitest";
import { BARE, moved, stackOf, withoutCoat } from "../../src/material/material";
import { PRESETS } from "../../src/material/presets";
import { Refusal } from "../../src/refusal";
import { readMaterial, readState } from "../../src/state/read";
import { INITIAL } from "../../src/state/state";

const BOTTOM = { kind: "diffuse", reflectance: 0.5 };

test.each(PRESETS)("the preset $name is within all ranges", (preset) => {
  expect(readMaterial(preset)).toEqual(preset);
});

test("what is missing has its first value", () => {
  const state = readState({ materials: [{ bottom: BOTTOM }] });
  expect(state).toEqual({
    ...INITIAL,
    materials: [{ name: "Material", bottom: BOTTOM, coats: [], solo: null }, INITIAL.materials[1]],
  });
});

test.each([undefined, "", "  ", 7])(
  "a material has a name, whatever the state says: %j",
  (name) => {
    expect(readMaterial({ bottom: BOTTOM, name }).name).toBe("Material");
  },
);

test("numbers outside their ranges become the nearest inside", () => {
  const coat = { alpha: 0, ior: [0.2, 1, 99], albedo: 7, sigmaT: -1, g: -3 };
  const material = readMaterial({ bottom: BOTTOM, coats: [coat] });
  expect(material.coats[0]).toMatchObject({
    alpha: 0.01,
    ior: [0.51, 1, 3],
    albedo: 1,
    sigmaT: 0,
    g: -0.99,
  });
});

test.each([
  null,
  [],
  "state",
  {},
  { materials: [] },
  { materials: [{}] },
  { materials: [{ bottom: { kind: "wood" } }] },
  { materials: [{ bottom: { kind: "diffuse", reflectance: "red" } }] },
  { materials: [{ bottom: { kind: "diffuse", reflectance: [0.1, 0.2] } }] },
  { materials: [{ bottom: { kind: "codes", latents: [1, 2] } }] },
  { materials: [{ bottom: BOTTOM, coats: Array(7).fill({}) }] },
  { materials: [{ bottom: BOTTOM, coats: [{ alpha: null }] }] },
])("%j is refused in one sentence", (value) => {
  let message = "";
  try {
    readState(value);
  } catch (error) {
    expect(error).toBeInstanceOf(Refusal);
    message = (error as Refusal).message;
  }
  expect(message).toMatch(/^[A-Z].*\.$/);
});

test("widths across the tangent, the angle and codes of anisotropic networks are kept", () => {
  const coat = { id: 1, on: true, alpha: 0.1, alphaV: 0.3, ior: 1.5, albedo: 0, sigmaT: 0, g: 0 };
  const bottom = { kind: "dielectric", alpha: 0.2, alphaV: [0.1, 0.2, 0.3], ior: 1.5 } as const;
  const material = { name: "satin", bottom, coats: [coat], rotation: -30, solo: null };
  expect(readMaterial(material)).toEqual(material);
  const codes = { kind: "codes", latents: [1, 2, 3], widths: 2 };
  expect(readMaterial({ bottom: codes }).bottom).toMatchObject({ widths: 2 });
  expect(readMaterial({ bottom, rotation: 500 }).rotation).toBe(180);
  expect(readMaterial({ bottom: { ...bottom, alphaV: 7 } }).bottom).toMatchObject({ alphaV: 1 });
});

test("the solo coat stays the same after coats were moved and removed", () => {
  const given = { bottom: BOTTOM, coats: [0.1, 0.2, 0.3].map((alpha) => ({ alpha })) };
  const material = moved(readMaterial(given), 0, 2);
  for (const solo of [1, 2, 3])
    expect(stackOf(readMaterial({ ...material, solo })).coats).toEqual(
      stackOf({ ...material, solo }).coats,
    );
  const last = withoutCoat(withoutCoat({ ...material, solo: 3 }, 1), 2);
  expect(readMaterial(last)).toMatchObject({ coats: [{ alpha: 0.3 }], solo: 1 });
  expect(readMaterial({ ...material, solo: 4 }).solo).toBe(null);
  expect(readMaterial({ ...material, solo: BARE }).solo).toBe(BARE);
});

test("a background is a colour or one of two words", () => {
  const read = (background: unknown) => readState({ materials: [{ bottom: BOTTOM }], background });
  expect(read("#12ab9f").background).toBe("#12ab9f");
  expect(read("transparent").background).toBe("transparent");
  for (const other of ["red", "#12ab9fx", "url(x)", 7, null])
    expect(read(other).background).toBe("environment");
});
