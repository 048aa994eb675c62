import { describe, expect, test } from "vitest";
import { type Picture, withoutLights } from "../../src/picture/panorama";

/** Irradiance of a surface that faces a direction [W/m²], of one channel. */
function irradiance({ width, height, pixels }: Picture, normal: readonly number[]): number {
  let sum = 0;
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const theta = (Math.PI * (y + 0.5)) / height;
      const phi = (2 * Math.PI * (x + 0.5)) / width;
      const way = [
        Math.sin(theta) * Math.sin(phi),
        Math.sin(theta) * Math.cos(phi),
        Math.cos(theta),
      ];
      const cosine = way.reduce((total, part, k) => total + part * normal[k], 0);
      const solidAngle = (2 * Math.PI ** 2 * Math.sin(theta)) / (width * height);
      sum += Math.max(cosine, 0) * solidAngle * pixels[3 * (y * width + x)];
    }
  return sum;
}

describe("bright lights", () => {
  const [width, height] = [128, 64];
  const panorama = { width, height, pixels: new Float32Array(3 * width * height).fill(0.5) };
  for (const [x, y] of [
    [20, 12],
    [21, 12],
    [90, 20],
  ] as const)
    panorama.pixels.fill(4000, 3 * (y * width + x), 3 * (y * width + x) + 3);
  const taken = withoutLights(panorama);

  test("are found, neighbours as one", () => {
    expect(taken.lights).toHaveLength(2);
  });

  test("together with the rest they light a surface as before", () => {
    for (const normal of [
      [0, 0, 1],
      [0.6, 0.48, 0.64],
    ]) {
      const direct = taken.lights.reduce((sum, { direction, power }) => {
        const cosine = direction.reduce((total, part, k) => total + part * normal[k], 0);
        return sum + Math.max(cosine, 0) * power[0];
      }, 0);
      const whole = irradiance(panorama, normal);
      expect(irradiance(taken.panorama, normal) + direct).toBeCloseTo(whole, 2);
    }
  });

  test("what is left of a panorama in large units fits numbers of half precision", () => {
    const large = panorama.pixels.map((value) => 1e5 * value);
    const left = withoutLights({ width, height, pixels: large });
    expect(left.lights).toHaveLength(2);
    expect(Math.max(...left.panorama.pixels)).toBeLessThan(65505);
  });

  test("an even panorama has none", () => {
    const even = { width, height, pixels: new Float32Array(3 * width * height).fill(2) };
    expect(withoutLights(even)).toEqual({ panorama: even, lights: [] });
  });
});
