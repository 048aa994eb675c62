import { describe, expect, test } from "vitest";
import { decoded, encoded, fromHex, hex } from "../../src/material/colour";
import {
  BARE,
  type BottomInAir,
  hasSurface,
  hasTangent,
  isAnisotropic,
  isSeen,
  type MaterialCards,
  moved,
  stackOf,
  widthRatio,
  withCoat,
  withoutCoat,
} from "../../src/material/material";
import {
  alphaOf,
  BOTTOM_PARAMETERS,
  COAT_PARAMETERS,
  GLOSS,
  glossOf,
  type Parameter,
  placeOf,
  STEPS,
  stepOf,
  valueAt,
  valueBeyond,
} from "../../src/material/parameters";
import { Draws } from "./random";

const COAT = { alpha: 0.1, ior: 1.5, albedo: 0, sigmaT: 0, g: 0 };
const THREE: MaterialCards = {
  name: "three",
  bottom: { kind: "diffuse", reflectance: 0.5 },
  coats: [1, 2, 3].map((id) => ({ ...COAT, alpha: id / 10, id, on: id !== 2 })),
  solo: null,
};
const widths = (material: MaterialCards) => stackOf(material).coats.map((coat) => coat.alpha);

describe("two widths", () => {
  const [top, ...others] = THREE.coats;
  const withAcross = (alphaV: number | [number, number, number]): MaterialCards => ({
    ...THREE,
    coats: [{ ...top!, alphaV }, ...others],
  });
  test("need the anisotropic networks when they differ in any channel", () => {
    expect(isAnisotropic(stackOf(THREE))).toBe(false);
    expect(isAnisotropic(stackOf(withAcross(0.1)))).toBe(false);
    expect(isAnisotropic(stackOf(withAcross(0.2)))).toBe(true);
    expect(isAnisotropic(stackOf(withAcross([0.1, 0.1, 0.2])))).toBe(true);
  });
  test("have a ratio, whichever is larger", () => {
    const ratios = [0.01, 0.1, [0.4, 0.05, 0.1] as [number, number, number]];
    const found = ratios.map((across) => widthRatio(withAcross(across).coats[0]));
    expect(found.map((ratio) => Number(ratio.toFixed(9)))).toEqual([10, 1, 4]);
    expect(widthRatio(top!)).toBe(1);
  });
  test("of a coat that is not shown do not count", () => {
    const material = withAcross(0.2);
    expect(isAnisotropic(stackOf({ ...material, solo: BARE }))).toBe(false);
    expect(hasTangent(material) && !hasTangent(THREE)).toBe(true);
  });
});

describe("the stack that is shown", () => {
  test("has the coats that are on, the topmost first", () => {
    expect(widths(THREE)).toEqual([0.1, 0.3]);
  });
  test("has the solo coat alone, even if it is off", () => {
    expect(widths({ ...THREE, solo: 2 })).toEqual([0.2]);
    expect(widths({ ...THREE, solo: BARE })).toEqual([]);
  });
  test("follows a moved card", () => {
    expect(moved(THREE, 0, 2).coats.map((coat) => coat.id)).toEqual([2, 3, 1]);
    expect(moved(THREE, 2, 0).coats.map((coat) => coat.id)).toEqual([3, 1, 2]);
    expect(moved(THREE, 0, 9).coats.map((coat) => coat.id)).toEqual([2, 3, 1]);
  });
});

describe("indices are absolute", () => {
  const [top, , lowest] = THREE.coats;
  const etas = (...iors: number[]) =>
    stackOf({ ...THREE, coats: iors.map((ior) => ({ ...top!, ior })) }).coats.map(({ eta }) => eta);
  const under = (bottom: BottomInAir, ...iors: number[]) =>
    stackOf({ ...THREE, bottom, coats: iors.map((ior) => ({ ...top!, ior })) }).bottom;

  test("and their ratios those of an interface, nearest within the networks' range", () => {
    expect(etas(1.5, 1.7)).toEqual([1.5 / 1.000277, 1.7 / 1.5]);
    expect(etas(1.5, 1.5, 1.5005, 1.3)).toEqual([1.5 / 1.000277, 1, 1, 1.3 / 1.5005]);
    const [first, second] = etas(3, 0.6);
    expect(first).toBe(3 / 1.000277);
    expect(second).toBeGreaterThanOrEqual(0.5); // as Python checks what is saved
    expect(second).toBeCloseTo(0.5, 5);
  });
  test("of coats that are hidden do not count", () => {
    const hidden = { ...top!, ior: 2, on: false };
    expect(stackOf({ ...THREE, coats: [hidden, lowest!] })).toEqual(
      stackOf({ ...THREE, coats: [lowest!] }),
    );
  });
  test("gold under a varnish reflects as Fresnel's closed form has it", () => {
    const gold = { kind: "conductor", alpha: 0.1, eta: 0.143, k: 3.983 } as const;
    const { eta, k } = under(gold, 1.5) as typeof gold;
    const index = 1.5 / 1.000277;
    const square = 0.143 ** 2 + 3.983 ** 2 + index ** 2;
    const expected = (square - 2 * 0.143 * index) / (square + 2 * 0.143 * index);
    expect(((eta - 1) ** 2 + k ** 2) / ((eta + 1) ** 2 + k ** 2)).toBeCloseTo(expected, 9);
    expect(under(gold)).toEqual(gold);
  });
  test("of bottoms: dielectrics have the ratio, Schlick's metals what they reflect", () => {
    expect(under({ kind: "dielectric", alpha: 0.1, ior: 1.9 }, 1.5)).toEqual({
      kind: "dielectric",
      alpha: 0.1,
      eta: 1.9 / 1.5,
    });
    const metal = { kind: "conductor", alpha: 0.1, r0: 0.9 } as const;
    expect(under(metal, 1.5)).toEqual(metal);
  });
  test("of loaded metals too", () => {
    const code = (eta: number, k: number) => [0.1, 0, 0, 1, eta, k, 0.25];
    const codes = Float32Array.from([code(0.5, 3), code(2, 0), code(0.25, 6)].flat());
    const { latents } = under({ kind: "codes", latents: codes }, 2.000554) as {
      latents: Float32Array;
    };
    expect(latents).toEqual(
      Float32Array.from([code(0.25, 1.5), code(2, 0), code(0.125, 3)].flat()),
    );
  });
});

test("cards have numbers of their own, and at most six are added", () => {
  let material = withoutCoat(THREE, 1);
  for (let count = 0; count < 9; count++) material = withCoat(material);
  expect(material.coats).toHaveLength(6);
  expect(new Set(material.coats.map((coat) => coat.id)).size).toBe(6);
});

test("a coat has a surface where the stack that is shown has one", () => {
  // Below an index of 3, that of 0.51 is shown as 1.5.
  const iors = [3, 0.51, 1.5];
  const limited = {
    ...THREE,
    coats: iors.map((ior, at) => ({ ...COAT, ior, id: at + 1, on: true })),
  };
  const draws = new Draws(3);
  for (const material of [THREE, limited, ...Array.from({ length: 200 }, () => draws.material())]) {
    const seen = material.coats.filter((coat) => isSeen(material, coat));
    const found = seen.map((coat) => hasSurface(material, coat));
    const etas = stackOf(material).coats.map(({ eta }) =>
      [eta].flat().some((ratio) => ratio !== 1),
    );
    expect(found).toEqual(etas);
  }
  expect(hasSurface(limited, limited.coats[2]!)).toBe(false);
});

test("removing the solo coat shows the others", () => {
  expect(widths(withoutCoat({ ...THREE, solo: 1 }, 1))).toEqual([0.3]);
});

const PARAMETERS = { ...COAT_PARAMETERS, ...BOTTOM_PARAMETERS, GLOSS };

test.each(Object.entries<Parameter>(PARAMETERS))(
  "%s: the slider reaches all of its range and gives back its values, step by step",
  (_name, parameter) => {
    const end = parameter.slide ?? parameter.high;
    expect(valueAt(parameter, 0)).toBeCloseTo(parameter.low, 3);
    expect(valueAt(parameter, 1)).toBeCloseTo(end, 3);
    for (const place of [0.1, 0.35, 0.5, 0.77, 0.95])
      expect(placeOf(parameter, valueAt(parameter, place))).toBeCloseTo(place, 1);
    // An arrow key moves on from wherever the slider is.
    for (const [way, last] of [
      [1, STEPS],
      [-1, 0],
    ] as const) {
      let value = valueAt(parameter, way > 0 ? 0 : 1);
      while (stepOf(parameter, value) !== last) {
        const next = valueBeyond(parameter, stepOf(parameter, value) + way, value);
        expect(way * (next - value)).toBeGreaterThan(0);
        value = next;
      }
    }
  },
);

test("every gloss of three digits, and thus every step of its slider, is a width of its own", () => {
  for (let k = 0; k <= 1000; k++) expect(glossOf(alphaOf(k / 1000))).toBe(k / 1000);
});

describe("colours", () => {
  test("sRGB's curve and its inverse", () => {
    for (const x of [0, 0.001, 0.0031308, 0.2, 0.5, 1])
      expect(decoded(encoded(x))).toBeCloseTo(x, 6);
    expect(encoded(0.2140411)).toBeCloseTo(0.5, 5); // half of the digital range
  });
  test("as text", () => {
    expect(hex([0, 0.2158605, 1])).toBe("#0080ff");
    expect(fromHex("#0080ff")).toEqual([0, 0.216, 1]);
  });
});
