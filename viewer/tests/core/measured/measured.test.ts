/** Measured files: what they say is read, and damaged ones get one sentence. */

import { describe, expect, test } from "vitest";
import { loadCore } from "../../../src/core/core";
import type { Direction } from "../../../src/core/measured/half_vector";
import { readMeasured } from "../../../src/core/measured/read";
import { FileError } from "../../../src/core/safetensors";
import { bytesOf, SHIPPED } from "../vectors";
import { merlFile, rglTensors, type Tensor, tensorFile } from "./files";

function direction(theta: number, phi: number): Direction {
  return [Math.sin(theta) * Math.cos(phi), Math.sin(theta) * Math.sin(phi), Math.cos(theta)];
}

const DIRECTIONS = [0.1, 0.5, 0.9, 1.3].map((theta, k) => direction(theta, 2.2 * k));
const PAIRS = DIRECTIONS.flatMap((wi) => DIRECTIONS.map((wo) => [wi, wo] as const));

describe("a MERL table", () => {
  test("is interpolated linearly in its own angles", () => {
    const plane = (h: number, d: number) => 0.1 + 0.2 * Math.sqrt(h) + 0.05 * d;
    const measured = readMeasured(merlFile((h, d) => [plane(h, d), 0.5, 2 * plane(h, d)]));
    for (const [wi, wo] of PAIRS) {
      const half = wi.map((x, k) => x + wo[k]!);
      const size = Math.hypot(...half);
      const thetaH = Math.acos(Math.min(half[2]! / size, 1));
      const thetaD = Math.acos(Math.min(size / 2, 1));
      // Below the first centres, their value is used.
      const h = Math.max(thetaH, (0.5 / 90) ** 2 * (Math.PI / 2));
      const d = Math.max(thetaD, Math.PI / 360);
      const [red, green, blue] = measured.f(wi, wo);
      expect(red).toBeCloseTo(plane(h, d), 5);
      expect(green).toBeCloseTo(0.5, 5);
      expect(blue).toBeCloseTo(2 * plane(h, d), 5);
    }
  });

  test("takes values from beside bins that were not measured", () => {
    const measured = readMeasured(
      merlFile((_h, d, phi) => (d > 1 || phi < 0.2 ? [-1, -1, -1] : [0.3, 0.2, 0.1])),
    );
    for (const [wi, wo] of PAIRS)
      measured.f(wi, wo).forEach((value, k) => {
        expect(value).toBeCloseTo([0.3, 0.2, 0.1][k]!, 6);
      });
  });

  test("is the same with exchanged directions", () => {
    const measured = readMeasured(merlFile((h, d, phi) => [h, d, phi]));
    for (const [wi, wo] of PAIRS) expect(measured.f(wi, wo)).toEqual(measured.f(wo, wi));
  });
});

test("an RGL material of even warps is S D / (4 sigma cos)", () => {
  const rgb = [0.2, 0.4, 0.9] as const;
  const measured = readMeasured(tensorFile(rglTensors(rgb)));
  for (const [wi, wo] of PAIRS)
    measured.f(wi, wo).forEach((value, k) => {
      expect(value).toBeCloseTo((rgb[k]! * 3) / (4 * 0.5 * wo[2]), 5);
    });
});

test("an even spectrum is grey", () => {
  const tensors = rglTensors([0.5, 0.5, 0.5]);
  const { rgb, ...others } = tensors;
  const wavelengths = { shape: [3], values: new Float32Array([400, 550, 700]) };
  const measured = readMeasured(tensorFile({ ...others, wavelengths, spectra: rgb! }));
  for (const [wi, wo] of PAIRS)
    for (const value of measured.f(wi, wo))
      expect(value).toBeCloseTo((0.5 * 3) / (4 * 0.5 * wo[2]), 5);
});

test("a Lambertian table is encoded as one", { timeout: 120_000 }, () => {
  const core = loadCore(bytesOf(SHIPPED));
  const reflectance = [0.6, 0.3, 0.1] as const;
  const [red, green, blue] = reflectance.map((x) => x / Math.PI) as [number, number, number];
  const material = core.encodeMeasured(merlFile(() => [red, green, blue]));
  const coded = core.layer({ bottom: { kind: "codes", latents: material.latents }, coats: [] });
  // The codes of diffuse surfaces are within some per cent, the table within half precision's rounding.
  for (const [one, bound] of [
    [coded, 0.03],
    [material, 0.002],
  ] as const)
    core.albedo(one, Float32Array.of(0.3, 0.7, 1)).forEach((value, at) => {
      expect(Math.abs(value / reflectance[at % 3]! - 1)).toBeLessThan(bound);
    });
});

describe("a damaged file gets one sentence", () => {
  const good = rglTensors([1, 1, 1]);
  const whole = tensorFile(good);
  const changed = (name: string, change: (values: Float32Array) => void): ArrayBuffer => {
    const values = (good[name]!.values as Float32Array).slice();
    change(values);
    return tensorFile({ ...good, [name]: { shape: good[name]!.shape, values } });
  };
  const without = (name: string): ArrayBuffer => {
    const { [name]: _, ...others } = good;
    return tensorFile(others as Record<string, Tensor>);
  };
  const merl = new Uint8Array(new Int32Array([90, 90, 180, 0, 0]).buffer).buffer;
  const files: [string, ArrayBuffer, RegExp][] = [
    ["nothing", new ArrayBuffer(0), /neither a MERL table/],
    ["text", new TextEncoder().encode("BRDF, I swear, this is one").buffer, /neither/],
    ["other dimensions", new Int32Array([90, 90, 360, 0]).buffer, /neither/],
    ["a truncated MERL table", merl, /truncated \(20 bytes/],
    ...[12, 13, 20, 40, whole.byteLength - 1].map((length): [string, ArrayBuffer, RegExp] => [
      `${length} bytes of an RGL file`,
      whole.slice(0, length),
      /truncated|outside of the file/,
    ]),
    ["a huge tensor", tensorFile(good, { rgb: [2 ** 30, 2 ** 30] }), /outside of the file/],
    ["too few elevations", tensorFile(good, { rgb: [1, 3, 3, 5, 5] }), /shapes|not fit/],
    ["no vndf", without("vndf"), /no tensor 'vndf'/],
    ["a number that is not finite", changed("ndf", (x) => x.fill(Number.NaN)), /not finite/],
    ["elevations that do not increase", changed("theta_i", (x) => x.fill(1)), /not increase/],
    ["a negative density", changed("ndf", (x) => x.fill(-1)), /negative/],
    ["no area", changed("sigma", (x) => x.fill(0)), /not positive/],
    ["no visible normals", changed("vndf", (x) => x.fill(0)), /no density/],
    [
      "an anisotropic material",
      changed("ndf", (x) => {
        x[0] = 9;
      }),
      /anisotropic/,
    ],
  ];

  test.each(files)("%s", (_name, file, sentence) => {
    expect(() => readMeasured(file)).toThrow(FileError);
    expect(() => readMeasured(file)).toThrow(sentence);
  });
});
