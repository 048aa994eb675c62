/**
 * The picture at rest is Mitsuba's of the same material, object, camera and environment; the objects hide
 * none of their own light here.
 */

import type { BottomInAir, CoatInAir } from "../../src/material/material";
import { METALS } from "../../src/material/presets";
import type { EnvironmentName, ObjectName } from "../../src/state/state";
import { expectAlike, hasFlip } from "./compared";
import { addressOf, expect, give, hdrFile, open, refined, test } from "./page";

interface Case {
  bottom: BottomInAir;
  coats: Partial<CoatInAir>[];
  object: ObjectName;
  environment: EnvironmentName;
  /** Only in `make test-web`: other cases have such a lobe, or such a light, too. */
  long?: true;
}

function metal(name: keyof typeof METALS & string, alpha: number): BottomInAir {
  return { kind: "conductor", alpha, ...METALS[name] };
}

const CASES: Record<string, Case> = {
  matte: {
    bottom: { kind: "diffuse", reflectance: [0.6, 0.3, 0.1] },
    coats: [],
    object: "teapot",
    environment: "own",
    long: true,
  },
  "smooth metal": {
    bottom: metal("Silver", 0.05),
    coats: [],
    object: "ball",
    environment: "room",
    long: true,
  },
  "rough metal": {
    bottom: metal("Copper", 0.4),
    coats: [],
    object: "sheet",
    environment: "sky",
    long: true,
  },
  "clear coat": {
    bottom: { kind: "diffuse", reflectance: [0.5, 0.05, 0.04] },
    coats: [{ alpha: 0.05 }],
    object: "ball",
    environment: "own",
  },
  "tinted gold": {
    bottom: metal("Gold", 0.2),
    coats: [{ alpha: 0.1, sigmaT: [0.1, 0.3, 0.9] }],
    object: "ball",
    environment: "studio",
    long: true,
  },
  "three layers": {
    bottom: metal("Aluminium", 0.3),
    coats: [
      { alpha: 0.03, ior: 1.45 },
      { alpha: 0.1, ior: 1.6, sigmaT: [2, 1, 0.3], albedo: [0.2, 0.5, 0.9], g: 0.3 },
    ],
    object: "ball",
    environment: "sky",
  },
  "turned copper": {
    bottom: { ...metal("Copper", 0.1), alphaV: 0.35 } as BottomInAir,
    coats: [{ alpha: 0.1, sigmaT: [0.05, 0.2, 0.4] }],
    object: "teapot",
    environment: "studio",
  },
};

/** Share of the frames that is drawn: the mean of a part is the same, with more noise. */
const SHARE = 1 / 3;

/** A panorama with a sky, a ground, and a small sun: 256 by 128 pixels, as a .hdr file. */
function sunny(): Buffer {
  const [width, height] = [256, 128];
  const pixels = Buffer.alloc(4 * width * height);
  for (let y = 0; y < height; y++)
    for (let x = 0; x < width; x++) {
      const up = Math.cos((Math.PI * (y + 0.5)) / height);
      const isSun = Math.abs(x - 40) < 2 && Math.abs(y - 40) < 2;
      const sky = [0.4 + 0.2 * up, 0.5 + 0.3 * up, 0.7 + 0.5 * up];
      const colour = isSun ? [1500, 1400, 1200] : up > 0 ? sky : [0.25, 0.2, 0.15];
      const exponent = Math.floor(Math.log2(Math.max(...colour))) + 1;
      const mantissas = colour.map((part) => Math.round((part / 2 ** exponent) * 256 - 0.5));
      pixels.set([...mantissas, exponent + 128], 4 * (y * width + x));
    }
  return hdrFile(width, height, pixels);
}

// One canvas pixel for several of the screen: the processor draws.
test.use({ deviceScaleFactor: 0.16, picture: true, refined: SHARE });
test.skip(!hasFlip, "the package flip-evaluator has no wheel for this machine");

for (const [name, { bottom, coats, object, environment, long }] of Object.entries(CASES))
  test(`${name}: as Mitsuba renders it`, { tag: long ? "@long" : [] }, async ({ page }) => {
    test.setTimeout(1_200_000);
    const materials = [{ name, bottom, coats }];
    const view = { azimuth: 20, elevation: 25, zoom: 1.4 };
    await open(page, addressOf({ materials, object, environment, view, rotation: 30 }));
    if (environment === "own") {
      await give(page, "sunny.hdr", sunny());
      await expect(page.getByRole("combobox", { name: "Light" })).toContainText("sunny.hdr");
    }
    await expect(page.getByRole("button", { name: `Material ${name}` })).toBeVisible();
    await expect(page.locator(".status")).toHaveText("refining");
    await refined(page, SHARE);
    const { tone } = await expectAlike(page, name);
    // Rounding to a step of the screen, of which half is dither
    expect.soft(tone).toBeLessThan(1.1 / 255);
  });
