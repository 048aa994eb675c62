/** The picture: it is there, follows the cards, and its absence is told. */

import { lookOf } from "../../src/material/appearance";
import { rgb } from "../../src/material/channels";
import { decoded, encoded } from "../../src/material/colour";
import { METALS, preset } from "../../src/material/presets";
import { readPicture } from "../../src/picture/picture_files";
import { INITIAL } from "../../src/state/state";
import {
  addressOf,
  colourAt,
  enter,
  expect,
  give,
  number,
  open,
  panorama,
  pixelsOf,
  refined,
  saved,
  seen,
  stateOf,
  test,
  unfold,
} from "./page";

// One canvas pixel for several of the screen: the processor draws.
test.use({ deviceScaleFactor: 0.4, picture: true });

/** A matt ball in a small picture, where everything is fast; both materials are the same. */
async function matt(page: import("@playwright/test").Page, reflectance: number[]): Promise<void> {
  await page.setViewportSize({ width: 640, height: 250 });
  const one = { name: "matt", bottom: { kind: "diffuse", reflectance } };
  await open(page, addressOf({ materials: [one, one], object: "ball" }));
}

test("the picture shows the material, and follows it, the exposure and the keyboard", async ({
  page,
}) => {
  await matt(page, [0.8, 0.1, 0.1]);
  const red = async () => (await colourAt(page, 0.5, 0.4))[0];
  const redness = async () => (await red()) / (await colourAt(page, 0.5, 0.4))[1];
  await expect.poll(redness).toBeGreaterThan(1.8);
  await enter(page, "Bottom, Reflectance, red", "0.05");
  await expect.poll(redness).toBeLessThan(1);

  const before = await red();
  await page.getByRole("slider", { name: "Exposure" }).focus();
  for (let step = 0; step < 10; step++) await page.keyboard.press("ArrowRight");
  await expect.poll(red).toBeGreaterThan(1.15 * before);

  await page.locator(".stage canvas").focus();
  await page.keyboard.press("ArrowRight");
  await expect.poll(async () => (await stateOf(page)).view.azimuth).toBe(INITIAL.view.azimuth + 5);
});

test("two materials are compared by a swipe, and by a difference that is dark where they agree", async ({
  page,
}) => {
  await matt(page, [0.8, 0.1, 0.1]);
  await page.getByRole("button", { name: "Swipe" }).click();
  await page.getByRole("button", { name: /^B / }).click();
  const reflectance = async (values: number[]) => {
    for (const [at, channel] of ["red", "green", "blue"].entries())
      await enter(page, `Bottom, Reflectance, ${channel}`, values[at]);
  };
  await reflectance([0.1, 0.1, 0.8]);
  const edge = page.getByRole("slider", { name: "Edge between A and B" });
  await expect(edge).toHaveAttribute("aria-valuenow", "50");
  const isRed = async (x: number) => {
    const [red, , blue] = await colourAt(page, x, 0.4);
    return red > blue;
  };
  await expect.poll(async () => [await isRed(0.45), await isRed(0.55)]).toEqual([true, false]);
  await edge.press("End");
  await expect(edge).toHaveAttribute("aria-valuenow", "98");
  await edge.press("Home");
  await expect(edge).toHaveAttribute("aria-valuenow", "2");
  for (let step = 0; step < 32; step++) await page.keyboard.press("ArrowRight");
  await expect(edge).toHaveAttribute("aria-valuenow", "66");
  await expect.poll(() => isRed(0.55)).toBe(true);

  await page.getByRole("button", { name: "Difference" }).click();
  const sum = async () => (await colourAt(page, 0.5, 0.4)).reduce((a, b) => a + b);
  await page.getByLabel("Largest difference").selectOption("10");
  await page.getByRole("button", { name: /^A / }).click();
  await reflectance([0.3, 0.3, 0.3]);
  await page.getByRole("button", { name: /^B / }).click();
  await reflectance([0.3, 0.3, 0.3]);
  await expect.poll(sum).toBeLessThan(12);
  // The same lightness in another colour is a difference, too.
  await reflectance([0.3, 0.32, 0.18]);
  await expect.poll(sum).toBeGreaterThan(300);
  let before = 0; // once it does not change any more
  await expect
    .poll(
      async () => {
        const last = before;
        before = await sum();
        return Math.abs(before - last);
      },
      { intervals: [1000] },
    )
    .toBeLessThan(2);
  await page.getByLabel("Largest difference").selectOption("50");
  await expect.poll(sum).toBeLessThan(before - 50);
  const legend = page.locator(".legend");
  await expect(legend).toContainText(/mean [1-9]/);
  await page.getByRole("button", { name: "Copy to A" }).click();
  await expect(legend).toContainText("mean 0.0, largest 0.0");
});

/** Radiance of a shown colour below 0.7: sRGB and the neutral tone curve undone. */
function radiance(shown: number[]): number[] {
  const toned = shown.map((value) => decoded(value / 255));
  const least = Math.min(...toned);
  const offset = least >= 0.04 ? 0.04 : Math.sqrt(least / 6.25) - least;
  return toned.map((value) => value + offset);
}

test("in an even light the picture is the directional albedo", async ({ page }) => {
  await page.setViewportSize({ width: 640, height: 250 });
  await open(page, addressOf({ materials: [preset("Gilding under shellac")], object: "ball" }));
  await give(page, "even.hdr", panorama(64, 32, [64, 64, 64, 129])); // radiance 0.5
  const label = page.getByRole("img", { name: /^Directional albedo in percent/ });
  await expect(label).toHaveAttribute("aria-label", /: (?!NaN)\d+, \d+, \d+ near the normal/);
  const albedo = async () => {
    const text = (await label.getAttribute("aria-label"))!;
    return /: (\d+), (\d+), (\d+) near/
      .exec(text)!
      .slice(1)
      .map((x) => Number(x) / 100);
  };
  // The quadrature of few directions is within two percent of the light.
  await expect
    .poll(async () => {
      const shown = radiance(await colourAt(page, 0.5, 0.5));
      const known = await albedo();
      return Math.max(...known.map((x, k) => Math.abs(shown[k] / 0.5 - x)));
    })
    .toBeLessThan(0.02);
});

test.describe("a hollow object", () => {
  test.use({ occlusion: true });

  test("hides a part of its own light, and a ball none", async ({ page }) => {
    await matt(page, [0.5, 0.5, 0.5]);
    await give(page, "even.hdr", panorama(64, 32, [64, 64, 64, 129])); // radiance 0.5
    const seen = async () => radiance(await colourAt(page, 0.5, 0.4))[0] / 0.25;
    await expect.poll(async () => Math.abs((await seen()) - 1)).toBeLessThan(0.03);
    await page.getByRole("combobox", { name: "Object" }).selectOption("bowl");
    await expect.poll(seen).toBeLessThan(0.88);
    // The shadow of the sun is in the light of the sky.
    await page.getByRole("combobox", { name: "Light" }).selectOption("sky");
    const darkest = async () => {
      const places = Array.from({ length: 9 }, (_, k) => 0.56 + 0.05 * k);
      const colours = await Promise.all(places.map((x) => colourAt(page, x, 0.72)));
      return Math.min(...colours.map((colour) => Math.max(...colour)));
    };
    await expect.poll(async () => Math.abs((await darkest()) - 60)).toBeLessThan(20);
  });
});

test.describe("the studio's light", () => {
  test.use({ deviceScaleFactor: 0.3, refined: 0.1 });

  test("shows a lacquer's colour in the middle of a body", async ({ page }) => {
    await page.setViewportSize({ width: 900, height: 500 });
    const [lacquer] = INITIAL.materials;
    await open(page, addressOf({ materials: [lacquer], object: "bowl" }));
    const swatch = rgb(lookOf(lacquer.coats[1]).bodyColor).map((x) => 255 * encoded(x));
    await expect
      .poll(async () => {
        const seen = await colourAt(page, 0.5, 0.6);
        return Math.max(...seen.map((x, k) => Math.abs(x / swatch[k] - 1)));
      })
      .toBeLessThan(0.15);
  });

  test("lets the contour of a silver ball be read all around", async ({ page }) => {
    await page.setViewportSize({ width: 900, height: 500 });
    const silver = { kind: "conductor", alpha: 0.03, ...METALS.Silver };
    const materials = [{ name: "silver", bottom: silver }];
    await open(page, addressOf({ materials, object: "ball" }));
    const steps = async () => {
      const { width, height, at } = await seen(page);
      const radius = 0.318 * height; // of the ball at zoom 1
      const grey = (share: number, angle: number) => {
        const [x, y] = [Math.cos(angle), Math.sin(angle)].map((way) => share * radius * way);
        return at(Math.round(width / 2 + x!), Math.round(height / 2 + y!))[1];
      };
      return Array.from({ length: 36 }, (_, k) => (Math.PI / 18) * k)
        .map((angle) => Math.abs(grey(0.94, angle) - grey(1.06, angle)))
        .sort((a, b) => a - b);
    };
    // A tenth of the contour may be fainter. A slow machine shows fewer pixels, and a little less.
    await expect.poll(async () => (await steps())[3]).toBeGreaterThanOrEqual(15);
  });
});

test.describe("a coarse first frame", () => {
  test.use({ deviceScaleFactor: 1, refined: 0, viewport: { width: 1440, height: 900 } });

  test("has no dashes along a thin rim", async ({ page }) => {
    const silver = { name: "silver", bottom: { kind: "conductor", alpha: 0.05, ...METALS.Silver } };
    await open(page, addressOf({ materials: [silver] }));
    /** Mean step, of every four pixels along the rim, of what is darkest there. */
    const step = async () => {
      const { width, height, at } = await seen(page);
      const darkest = Array.from({ length: Math.floor(width / 8) }, (_, k) =>
        Math.min(
          ...Array.from(
            { length: Math.round(0.07 * height) },
            (_, y) => at(Math.round(0.25 * width) + 4 * k, Math.round(0.3 * height) + y)[1],
          ),
        ),
      );
      if (Math.max(...darkest) === 0) return Infinity; // not drawn yet
      const steps = darkest.slice(1).map((value, k) => Math.abs(value - darkest[k]));
      return steps.reduce((sum, value) => sum + value) / steps.length;
    };
    await expect.poll(step).toBeLessThan(7); // dashes have 17
  });
});

test("a lost context is told, and the picture returns", async ({ page }) => {
  await matt(page, [0.5, 0.5, 0.5]);
  const context = await page.locator(".stage canvas").evaluateHandle((element) => {
    const gl = (element as HTMLCanvasElement).getContext("webgl2")!;
    return gl.getExtension("WEBGL_lose_context")!;
  });
  await context.evaluate((extension) => extension.loseContext());
  await expect(page.getByText("The graphics driver has taken the picture away")).toBeVisible();
  await context.evaluate((extension) => extension.restoreContext());
  await expect(page.getByText("The graphics driver has taken the picture away")).toHaveCount(0);
  await expect.poll(async () => Math.max(...(await colourAt(page, 0.5, 0.5)))).toBeGreaterThan(5);
});

test("without WebGL 2 a sentence says so, and the cards work", async ({ page }) => {
  await page.addInitScript(() => {
    const original = HTMLCanvasElement.prototype.getContext;
    HTMLCanvasElement.prototype.getContext = function (this: HTMLCanvasElement, kind: string) {
      return kind === "webgl2" ? null : original.call(this, kind as "2d");
    } as typeof original;
  });
  await page.goto("./");
  await expect(page.getByText("This browser offers no WebGL 2")).toBeVisible();
  await page.getByRole("button", { name: "Remove Coat 2" }).click();
  await unfold(page);
  await expect(page.locator(".curve").first()).toBeVisible();
  for (const kind of ["Picture", "Radiance"]) {
    await page.getByRole("button", { name: "Save", exact: true }).click();
    await page.getByRole("button", { name: new RegExp(`^${kind}`) }).click();
    await expect(page.getByRole("alert")).toContainText("There is no picture to save");
    await page.getByRole("button", { name: "Close" }).click();
  }
});

test.describe("in a small picture", () => {
  test.use({ deviceScaleFactor: 0.2, refined: 1 / 3 });

  test("what is saved while it refines is that of the picture; a larger one can be cancelled", async ({
    page,
  }) => {
    await open(page);
    await page.getByRole("combobox", { name: "Object" }).selectOption("ball");
    const { width, height } = await page
      .locator(".stage canvas")
      .evaluate((canvas: HTMLCanvasElement) => ({ width: canvas.width, height: canvas.height }));
    const mean = async () => {
      const file = Buffer.from((await saved(page, "Radiance")).text, "latin1");
      const rows = file.subarray(file.length - height * (8 + 12 * width));
      let sum = 0;
      for (let y = 0; y < height; y++)
        for (let x = 0; x < 3 * width; x++)
          sum += rows.readFloatLE(y * (8 + 12 * width) + 8 + 4 * x);
      return sum / (3 * width * height);
    };
    const early = [await mean()];
    await expect(page.getByRole("alert")).toContainText("saved while refining, with");
    await page.getByRole("button", { name: "Close" }).click();
    for (const key of ["ArrowRight", "ArrowLeft"]) {
      await page.locator(".stage canvas").press(key);
      early.push(await mean());
    }
    await refined(page, 1 / 3); // the levels are as fine as the noise then
    const last = await mean();
    expect(last).toBeGreaterThan(0.01);
    // A first frame has coarse levels of the environment: they blur it, and keep its mean.
    for (const value of early) expect(Math.abs(value / last - 1)).toBeLessThan(0.05);

    await page.getByRole("button", { name: "Save", exact: true }).click();
    await page.getByRole("button", { name: "2 ×" }).click();
    const drawing = page.getByRole("progressbar", { name: "Drawing the large picture" });
    await expect(drawing).toBeVisible();
    await page.getByRole("button", { name: "Cancel" }).click();
    await expect(drawing).toHaveCount(0);

    await page.evaluate(() => {
      const draw = WebGL2RenderingContext.prototype.drawElements;
      WebGL2RenderingContext.prototype.drawElements = function (...args) {
        draw.apply(this, args);
        const isShown = this.canvas instanceof HTMLCanvasElement && this.canvas.isConnected;
        if (!isShown) this.getExtension("WEBGL_lose_context")?.loseContext();
      };
    });
    await page.getByRole("button", { name: "Save", exact: true }).click();
    await page.getByRole("button", { name: "2 ×" }).click();
    await expect(page.getByRole("alert")).toContainText("The graphics driver has ended it");
  });
});

/** Hill's fit of ACES (BakingLab, ACES.hlsl), with the exposure of three.js. */
function filmic(light: number[]): number[] {
  const times = (rows: number[][], v: number[]) =>
    rows.map((row) => row.reduce((sum, x, k) => sum + x * v[k], 0));
  const inner = times(
    [
      [0.59719, 0.35458, 0.04823],
      [0.076, 0.90834, 0.01566],
      [0.0284, 0.13383, 0.83777],
    ],
    light.map((x) => x / 0.6),
  );
  const fitted = inner.map(
    (x) => (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.432951) + 0.238081),
  );
  return times(
    [
      [1.60475, -0.53108, -0.07367],
      [-0.10208, 1.10813, -0.00605],
      [-0.00327, -0.07276, 1.07602],
    ],
    fitted,
  );
}

/** Beside the neutral one, which is compared with Mitsuba's picture. */
const CURVES = { filmic, none: (light: number[]) => light };

/** A mesh whose few triangles are drawn at once. */
const OCTAHEDRON = `
v 1 0 0
v 0 1 0
v 0 0 1
v -1 0 0
v 0 -1 0
v 0 0 -1
f 1 2 3
f 2 4 3
f 4 5 3
f 5 1 3
f 2 1 6
f 4 2 6
f 5 4 6
f 1 5 6
`;

test.describe("a saved picture", () => {
  test.use({ deviceScaleFactor: 0.2 });

  test("has the chosen tone curve, background and size", async ({ page }) => {
    await page.setViewportSize({ width: 640, height: 300 });
    const materials = [preset("Gilding under shellac")];
    await open(page, addressOf({ materials, object: "ball" }));
    await give(page, "octahedron.obj", OCTAHEDRON);
    await expect(page.getByRole("combobox", { name: "Object" })).toHaveValue("own");
    const choose = async (name: string, value: string) => {
      await page.getByRole("button", { name: "View", exact: true }).click();
      await page.getByRole("combobox", { name }).selectOption(value);
      await page.getByRole("button", { name: "View", exact: true }).click();
    };
    const picture = async (label = "Picture") => {
      await expect(page.locator(".status[data-converged=true]")).toBeVisible();
      return pixelsOf(page, Buffer.from((await saved(page, label)).text, "latin1"));
    };
    await choose("Background", "transparent");
    const one = await picture();
    const centre = Math.floor(one.height / 2) * one.width + Math.floor(one.width / 2);
    expect([...one.data.subarray(0, 4)]).toEqual([0, 0, 0, 0]);
    expect(one.data[4 * centre + 3]).toBe(255);

    const linear = readPicture(Buffer.from((await saved(page, "Radiance")).text, "latin1"), "exr");
    expect([one.width, one.height]).toEqual([linear.width, linear.height]);
    for (const [tone, curve] of Object.entries(CURVES)) {
      await choose("Tone curve", tone);
      const { data } = await picture();
      const differences = [...linear.pixels].map((_, at) => {
        const [pixel, k] = [Math.floor(at / 3), at % 3];
        if (one.data[4 * pixel + 3] !== 255) return 0;
        const known = curve([...linear.pixels.subarray(3 * pixel, 3 * pixel + 3)])[k];
        return Math.abs(data[4 * pixel + k] - 255 * encoded(known));
      });
      // Half a step of rounding, and half a step of noise
      expect(Math.max(...differences), tone).toBeLessThan(1.1);
    }

    await choose("Background", "colour");
    await page.getByRole("button", { name: "View", exact: true }).click();
    await page.getByLabel("Colour of the background").fill("#336699");
    expect([...(await picture()).data.subarray(0, 4)]).toEqual([0x33, 0x66, 0x99, 255]);

    await choose("Background", "transparent");
    // A pixel is the mean of the four of the picture of twice the size, whose parts have no seams.
    const two = await picture("2 ×");
    expect([two.width, two.height]).toEqual([2 * one.width, 2 * one.height]);
    let sum = 0;
    for (let y = 0; y < one.height; y++)
      for (let x = 0; x < one.width; x++) {
        let four = 0;
        for (let k = 0; k < 4; k++)
          four += two.data[4 * ((2 * y + (k >> 1)) * two.width + 2 * x + (k & 1)) + 3];
        sum += Math.abs(four / 4 - one.data[4 * (y * one.width + x) + 3]);
      }
    expect(sum / (one.width * one.height)).toBeLessThan(1);
  });
});

test.describe("at the screen's resolution", () => {
  test.use({ deviceScaleFactor: 1, picture: false });

  test("the picture has its place, and nothing is cut off, whatever the window's size", async ({
    page,
  }) => {
    await page.goto("./");
    for (const [width, height] of [
      [844, 390],
      [740, 360],
      [568, 320],
      [390, 844],
      [1440, 900],
      [2560, 1300],
    ] as const) {
      await page.setViewportSize({ width, height });
      await expect.poll(() => page.evaluate(() => innerWidth)).toBe(width);
      const stage = (await page.locator(".stage").boundingBox())!;
      const share = (stage.width * stage.height) / (width * height);
      expect(share, `${width} by ${height}`).toBeGreaterThan(0.3);
      const sizes = await page.evaluate(() => {
        const { scrollWidth, clientWidth } = document.documentElement;
        return [scrollWidth, clientWidth];
      });
      expect(sizes[0], `${width} by ${height}`).toBe(sizes[1]);
    }
  });
});

test.describe("by touch", () => {
  test.use({
    deviceScaleFactor: 1,
    picture: false,
    hasTouch: true,
    isMobile: true,
    viewport: { width: 390, height: 700 },
  });

  test("a swipe scrolls, a slider slides, and a pinch zooms", async ({ page, context }) => {
    await open(page);
    const session = await context.newCDPSession(page);
    const touch = (type: "touchStart" | "touchMove" | "touchEnd", ...places: number[][]) =>
      session.send("Input.dispatchTouchEvent", {
        type,
        touchPoints: places.map(([x, y], id) => ({ x: x!, y: y!, id })),
      });
    const place = () => page.evaluate(() => scrollY);
    /** Move a finger from a place on a slider to another; returns where the page was scrolled before. */
    const move = async (name: string, [fromX, fromY]: number[], [toX, toY]: number[]) => {
      const slider = page.getByRole("slider", { name });
      await slider.scrollIntoViewIfNeeded();
      const box = (await slider.boundingBox())!;
      const before = await place();
      const at = (part: number) => [
        box.x + box.width * (fromX! + (toX! - fromX!) * part),
        box.y + box.height / 2 + fromY! + (toY! - fromY!) * part,
      ];
      await touch("touchStart", at(0));
      for (let step = 1; step <= 10; step++) await touch("touchMove", at(step / 10));
      await page.waitForTimeout(300); // a finger at rest lets the page scroll no further
      await touch("touchMove", at(1));
      await touch("touchEnd");
      return before;
    };
    const field = number(page, "Coat 2, Index n");

    const first = await move("Coat 2, Index n", [0.8, 0], [0.8, -150]);
    await expect.poll(place).toBeGreaterThan(first + 50);
    await expect(field).toHaveValue("1.53");
    await page.evaluate(() => scrollTo(0, 0));
    await expect.poll(place).toBe(0);
    await move("Coat 2, Index n", [0.3, 0], [0.8, 0]);
    await expect
      .poll(async () => Math.abs(Number(await field.inputValue()) - 2.5))
      .toBeLessThan(0.2);
    // Beside the handle, at the end of the page
    const before = await move("Angle of incidence", [4, 0], [4, 120]);
    await expect.poll(place).toBeLessThan(before - 50);

    const box = (await page.locator(".stage canvas").boundingBox())!;
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    const apart = (half: number) => [
      [x - half, y],
      [x + half, y],
    ];
    await touch("touchStart", ...apart(40));
    for (let half = 44; half <= 80; half += 4) await touch("touchMove", ...apart(half));
    await touch("touchEnd");
    await expect.poll(async () => Math.abs((await stateOf(page)).view.zoom - 2)).toBeLessThan(0.1);
    const { view, incidence } = await stateOf(page);
    expect(view.azimuth).toBe(20);
    expect(incidence).toBe(45);
  });
});
