import { describe, expect, test } from "vitest";
import type { Physics } from "../../src/material/appearance";
import type { CoatCard, MaterialCards } from "../../src/material/material";
import { mitsubaXml } from "../../src/save/mitsuba";
import { fileName, pythonText } from "../../src/save/python";

const STACK: MaterialCards = {
  name: "My lacquer",
  bottom: { kind: "conductor", alpha: 0.2, eta: [0.2, 0.5, 1.3], k: 3 },
  coats: [
    { id: 1, on: true, alpha: 0.03, ior: 1.53, albedo: 0, sigmaT: [0.1, 0.2, 0.3], g: 0 },
    { id: 2, on: true, alpha: 0.4, ior: 1.7, albedo: 0.5, sigmaT: 2, g: 0.3 },
  ],
  solo: null,
};

test("Appearance, thickness and energy compensation are written as they were given", () => {
  const look = { color: [0.9, 0.6, 0.3] as const, body: 0.1, bodyColor: 0.8, thickness: 2 };
  const [{ albedo, sigmaT, ...top }] = STACK.coats as [CoatCard & Physics];
  const coats = [{ ...top, ...look }];
  const material = { ...STACK, coats, energyCompensation: true };
  const xml = mitsubaXml(material);
  expect(xml).toContain('<rgb name="color" value="0.9, 0.6, 0.3"/>');
  expect(xml).toContain('<boolean name="energy_compensation" value="true"/>');
  expect(xml).not.toContain("sigma_t");
});

test("Mitsuba XML: the topmost coat is the outermost", () => {
  const text = mitsubaXml(STACK);
  expect(text.match(/<bsdf type="\w+"/g)).toEqual([
    '<bsdf type="neural_layered"',
    '<bsdf type="neural_layered"',
    '<bsdf type="roughconductor"',
  ]);
  expect(text.indexOf('"int_ior" value="1.53"')).toBeLessThan(
    text.indexOf('"int_ior" value="1.7"'),
  );
  expect(text).toContain('<rgb name="sigma_t" value="0.1, 0.2, 0.3"/>');
  expect(text).toContain('<rgb name="k" value="3"/>');
  expect(text.match(/<bsdf/g)).toHaveLength(text.match(/<\/bsdf>/g)!.length);
});

describe("what has no such description", () => {
  const codes: MaterialCards = {
    ...STACK,
    bottom: { kind: "codes", latents: new Float32Array(3) },
    coats: [],
  };
  test.each([mitsubaXml, pythonText])("is refused in one sentence", (write) => {
    expect(() => write(codes)).toThrow(/loaded material.*\.$/);
  });
});

test("names of files", () => {
  expect(fileName("Enamel on copper")).toBe("enamel-on-copper");
  expect(fileName("漆")).toBe("material");
});
