import { expect, test } from "vitest";
import { shaderNumber, shaderText } from "../../src/save/shader";

test("numbers have a point and read back as the same number of single precision", () => {
  for (const value of [0, 1, -3, 0.1, -1.5e-9, 123456.789, 3.4e38, 1 / 3]) {
    const text = shaderNumber(Math.fround(value));
    expect(text).toMatch(/[.e]/);
    expect(Math.fround(Number(text))).toBe(Math.fround(value));
  }
  expect(shaderNumber(Math.fround(0.1))).toBe("0.1");
});

test("a template of anisotropic networks gets the tangent", () => {
  const template = "x = code_tangent_x; y = code_tangent_y;";
  const latents = new Float32Array(3);
  const text = shaderText(template, { latents }, 90);
  expect(text).toMatch(/^x = [-\d.e]+; y = 1\.0;$/);
  expect(Math.abs(Number(text.match(/x = ([^;]+)/)![1]))).toBeLessThan(1e-7);
});
