/**
 * Measures the page in Chromium: `PAGE=ADDRESS npm run measure`, of a page that `urushi view` serves.
 *
 * Prints the least and the median of several runs: first picture after the page has loaded, also by a
 * slow connection; the converged picture, 1440 by 900 pixels; and from a slider's step to the new
 * picture with six coats, the core's share apart.
 */

import { chromium } from "@playwright/test";

const RUNS = 5;
const STEPS = 12;
const COATS = 6;
const PAGE = process.env.PAGE ?? "http://127.0.0.1:8497/";

/** A mobile connection: bytes a second, and delay [ms]. */
const SLOW = { downloadThroughput: 1.6e6 / 8, uploadThroughput: 0.75e6 / 8, latency: 150 };

const browser = await chromium.launch({
  executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium-headless-shell",
  args: ["--no-sandbox"],
});

/** Runs in the page before its scripts: notes when a picture is complete, and when a table came. */
function watch() {
  window.pictures = [];
  window.tables = [];
  const { drawArrays, bindFramebuffer } = WebGL2RenderingContext.prototype;
  let shown = true;
  WebGL2RenderingContext.prototype.bindFramebuffer = function (target, frame) {
    shown = frame === null;
    bindFramebuffer.call(this, target, frame);
  };
  WebGL2RenderingContext.prototype.drawArrays = function (...all) {
    drawArrays.apply(this, all);
    if (!shown) return;
    this.finish();
    window.pictures.push(performance.now());
  };
  // Tables are of the codes that were asked for last before them.
  const tables = new Map();
  let layers = 0;
  const NativeWorker = window.Worker;
  window.Worker = class extends NativeWorker {
    constructor(...all) {
      super(...all);
      this.addEventListener("message", ({ data }) => {
        if (tables.get(data.id) === layers) window.tables.push(performance.now());
      });
    }
    postMessage(message, ...rest) {
      if (message.name === "layer") layers++;
      if (message.name === "table") tables.set(message.id, layers);
      super.postMessage(message, ...rest);
    }
  };
}

const first = [];
const core = [];
const whole = [];
for (let run = 0; run < RUNS; run++) {
  const page = await browser.newPage({ viewport: { width: 900, height: 640 } });
  await page.addInitScript(watch);
  await page.goto(PAGE);
  await page.waitForFunction(() => window.pictures.length > 0);
  first.push(
    await page.evaluate(() => {
      const [{ loadEventEnd }] = performance.getEntriesByType("navigation");
      return window.pictures[0] - loadEventEnd;
    }),
  );
  const add = page.getByRole("button", { name: "Add coat" });
  for (let tries = 0; tries < COATS && (await add.isEnabled()); tries++) await add.click();
  const slider = page.getByRole("slider", { name: `Coat ${COATS}, Gloss` });
  await slider.focus();
  // Steps follow each other as when the slider is dragged.
  const steps = await slider.evaluate(async (element, count) => {
    const wait = (time) => new Promise((resolve) => setTimeout(resolve, time));
    const found = [];
    for (let step = 0; step <= count; step++) {
      const start = performance.now();
      window.tables.length = window.pictures.length = 0;
      element.value = String(Number(element.value) - 1);
      element.dispatchEvent(new Event("input", { bubbles: true }));
      const drawn = () => window.pictures.find((at) => at > window.tables[0]);
      while (drawn() === undefined) await wait(1);
      found.push([window.tables[0] - start, drawn() - start]);
      await wait(30);
    }
    return found.slice(1); // the first one waits for the picture at rest
  }, STEPS);
  core.push(...steps.map(([table]) => table));
  whole.push(...steps.map(([, picture]) => picture));
  await page.close();
}

const converged = [];
for (let run = 0; run < RUNS; run++) {
  const page = await browser.newPage({ viewport: { width: 1440, height: 900 } });
  await page.goto(PAGE);
  await page.locator(".status[data-converged=true]").waitFor({ timeout: 600_000 });
  converged.push(
    await page.evaluate(() => {
      const [{ loadEventEnd }] = performance.getEntriesByType("navigation");
      return performance.now() - loadEventEnd;
    }),
  );
  await page.close();
}

const slow = [];
for (let run = 0; run < RUNS; run++) {
  const context = await browser.newContext({ viewport: { width: 900, height: 640 } });
  const page = await context.newPage();
  await page.addInitScript(watch);
  const session = await context.newCDPSession(page);
  await session.send("Network.emulateNetworkConditions", { offline: false, ...SLOW });
  await page.goto(PAGE);
  await page.waitForFunction(() => window.pictures.length > 0);
  slow.push(await page.evaluate(() => window.pictures[0]));
  await context.close();
}
await browser.close();

function told(times) {
  const sorted = [...times].sort((a, b) => a - b);
  const [least, middle] = [sorted[0], sorted[sorted.length >> 1]];
  return `${least.toFixed(0)} ms at least, ${middle.toFixed(0)} ms in the middle of ${times.length}`;
}

console.log(`first picture after the page has loaded: ${told(first)}`);
console.log(`converged picture, 1440 by 900, after the page has loaded: ${told(converged)}`);
console.log(`first picture by 1.6 Mbit/s from the start: ${told(slow)}`);
console.log(`slider to codes and table, ${COATS} coats: ${told(core)}`);
console.log(`slider to the picture, ${COATS} coats: ${told(whole)}`);
