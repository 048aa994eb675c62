/** What the tests of the page share: opening it, and what must never happen. */

import { readFileSync } from "node:fs";
import { test as base, expect, type JSHandle, type Page } from "@playwright/test";
import { fromAddress, toAddress, toJson } from "../../src/state/address";
import { INITIAL, type State } from "../../src/state/state";

interface Options {
  picture: boolean;
  refined: number;
  occlusion: boolean;
}

/**
 * A page on which nothing is logged, fails, or is asked of another server; `quiet`: what was.
 *
 * `picture`: whether the picture is drawn, which is slow by software; otherwise it has one frame. `refined`:
 * the picture stops to refine after this share of its frames. `occlusion`: whether objects hide a part of their own light, which takes a
 * second to compute.
 */
export const test = base.extend<Options & { quiet: string[] }>({
  picture: [false, { option: true }],
  refined: [1, { option: true }],
  occlusion: [false, { option: true }],
  // Of the context: pages that a test opens beside the first one are alike.
  context: async ({ context, picture, refined, occlusion }, use) => {
    if (!picture) await context.addInitScript(drawNothing);
    const share = picture ? refined : 0.01;
    if (share < 1) await context.addInitScript(refineTo, share);
    await context.addInitScript(answerAtOnce, { picture, refined, occlusion });
    await use(context);
  },
  quiet: [
    async ({ page, baseURL }, use) => {
      const complaints: string[] = [];
      page.on("console", (message) => {
        // Chromium's own advice about the driver is none of the page's messages.
        if (!message.text().includes("GL Driver Message")) complaints.push(message.text());
      });
      page.on("pageerror", (error) => complaints.push(String(error)));
      page.on("request", (request) => {
        const url = request.url();
        if (!url.startsWith(baseURL!) && !url.startsWith("blob:")) complaints.push(url);
      });
      await use(complaints);
      expect(complaints).toEqual([]);
    },
    { auto: true },
  ],
});

export { expect };

/** In the page: let WebGL draw nothing; all else is as ever. */
function drawNothing(): void {
  WebGL2RenderingContext.prototype.drawArrays = () => {};
  WebGL2RenderingContext.prototype.drawElements = () => {};
}

/** In the page: let WebGL finish nothing more once the picture has a share of its frames. */
function refineTo(share: number): void {
  const wait = WebGL2RenderingContext.prototype.clientWaitSync;
  WebGL2RenderingContext.prototype.clientWaitSync = function (...args) {
    const gathered = document.querySelector<HTMLProgressElement>(".status progress")?.value ?? 0;
    return gathered < share ? wait.apply(this, args) : this.TIMEOUT_EXPIRED;
  };
}

/**
 * In the page: answer calls for what is not wanted at once. Meshes hide none of their light, and the tables of a picture that nobody sees are all the first.
 */
function answerAtOnce(wanted: Options): void {
  const post = Worker.prototype.postMessage;
  const tables = new WeakMap<Worker, Float32Array>();
  Worker.prototype.postMessage = function (this: Worker, message, options) {
    const answer = (data: object) =>
      this.dispatchEvent(new MessageEvent("message", { data: { id: message.id, ...data } }));
    const later = message.name === "table" && Math.max(...message.args[1].shift) > 0;
    if (later && !wanted.picture && tables.has(this)) answer({ result: tables.get(this) });
    else if (message.name === "occlusion" && !wanted.occlusion) {
      const [vertices, stride] = message.args;
      const numbers = (4 * vertices.length) / stride;
      const openings = new Float32Array(numbers).map((_, at) => +(at % 4 === 3));
      answer({ result: { openings, shadows: new Uint8Array(0) } });
    } else {
      if (message.name === "table")
        this.addEventListener("message", ({ data }) => {
          if (data.id === message.id && data.result) tables.set(this, data.result);
        });
      post.call(this, message, options as StructuredSerializeOptions);
    }
  } as typeof post;
}

/** Wait until the picture has a share of its frames. */
export async function refined(page: Page, share: number): Promise<void> {
  const gathered = () => page.locator(".status progress").evaluate((bar) => Object(bar).value);
  await expect.poll(gathered, { timeout: 1_000_000 }).toBeGreaterThanOrEqual(share);
}

/** Open the page and wait until it computes; nothing on it is folded. */
export async function open(page: Page, address = ""): Promise<void> {
  await page.goto(`./${address}`);
  await expect(page.locator(".status")).not.toHaveText(/Loading/);
  await unfold(page);
}

/** Begin anew on a page that is open, which is faster than loading it. */
export async function reset(page: Page): Promise<void> {
  await give(page, "state.json", toJson(INITIAL));
  await expect.poll(() => stateOf(page)).toEqual(fromAddress(addressOf(INITIAL)));
  await unfold(page);
}

/** Show plots, channels of colours, and what is advanced. */
export async function unfold(page: Page): Promise<void> {
  for (const closed of ["details:not([open]) > summary", ".channels[aria-expanded=false]"]) {
    const all = page.locator(`.column :is(${closed})`);
    for (let left = await all.count(); left > 0; left--) await all.first().click();
  }
}

/** The address of a state, of which only some is given; the rest is as at first. */
export function addressOf(state: object): string {
  return `#${toAddress(state as State)}`;
}

/** The state that the address holds; it follows with a delay. */
export async function stateOf(page: Page): Promise<State> {
  return fromAddress(new URL(page.url()).hash || `#${toAddress(INITIAL)}`);
}

/** The names of the coats, the topmost first. */
export function coats(page: Page) {
  return page.getByRole("list", { name: "Coats, the topmost first" }).getByRole("listitem");
}

/** A number field of a parameter. */
export function number(page: Page, name: string) {
  return page.getByLabel(`${name}, number`, { exact: true });
}

/** Type a parameter's number. */
export async function enter(page: Page, name: string, value: string | number): Promise<void> {
  await number(page, name).fill(String(value));
  await number(page, name).press("Enter");
}

/** What the canvas shows: red, green and blue in [0, 255] at places [pixels], and its size. */
export async function seen(page: Page) {
  const bitmap = await page
    .locator(".stage canvas")
    .evaluateHandle((canvas) => createImageBitmap(canvas as HTMLCanvasElement));
  const { width, height, data } = await pixelsIn(bitmap);
  const at = (x: number, y: number): number[] => {
    const first = 4 * (Math.floor(y) * width + Math.floor(x));
    return [...data.subarray(first, first + 3)];
  };
  return { width, height, at };
}

/** The pixels (RGBA, the first row at the top) of a picture in the page. */
async function pixelsIn(bitmap: JSHandle<ImageBitmap>) {
  const { width, height, text } = await bitmap.evaluate((bitmap) => {
    const { width, height } = bitmap;
    const context = new OffscreenCanvas(width, height).getContext("2d")!;
    context.drawImage(bitmap, 0, 0);
    const { data } = context.getImageData(0, 0, width, height);
    // A list of millions of numbers would take long.
    return { width, height, text: Object(new Uint8Array(data.buffer)).toBase64() as string };
  });
  return { width, height, data: Buffer.from(text, "base64") };
}

/** The mean colour of a part of the picture, in [0, 255]; x and y from 0 to 1. */
export async function colourAt(page: Page, x: number, y: number): Promise<number[]> {
  const { width, height, at } = await seen(page);
  const part = Array.from({ length: 64 }, (_, k) =>
    at(x * width - 4 + (k % 8), y * height - 4 + Math.floor(k / 8)),
  );
  return [0, 1, 2].map((k) => part.reduce((sum, colour) => sum + colour[k], 0) / 64);
}

/** Open a file on the page. */
export async function give(page: Page, name: string, content: Buffer | string): Promise<void> {
  await page
    .locator("input[type=file]")
    .setInputFiles({ name, mimeType: "application/octet-stream", buffer: Buffer.from(content) });
}

/** A .hdr file of pixels of four bytes: mantissas and exponent. */
export function hdrFile(width: number, height: number, pixels: Uint8Array): Buffer {
  const header = `#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y ${height} +X ${width}\n`;
  return Buffer.concat([Buffer.from(header, "latin1"), pixels]);
}

/** A panorama of one colour, as a .hdr file; colour: mantissas and exponent. */
export function panorama(width: number, height: number, colour: number[]): Buffer {
  return hdrFile(width, height, Buffer.alloc(4 * width * height, Uint8Array.from(colour)));
}

/** The pixels (RGBA, the first row at the top) of a PNG file. */
export async function pixelsOf(page: Page, file: Buffer) {
  const bitmap = await page.evaluateHandle((text) => {
    const bytes = Uint8Array.from(text, (character) => character.charCodeAt(0));
    return createImageBitmap(new Blob([bytes]));
  }, file.toString("latin1"));
  return pixelsIn(bitmap);
}

/** What an entry of the menu Save writes; label: the beginning of its name. */
export async function saved(page: Page, label: string): Promise<{ name: string; text: string }> {
  await page.getByRole("button", { name: "Save", exact: true }).click();
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: new RegExp(`^${label}`) }).click();
  const file = await download;
  return { name: file.suggestedFilename(), text: readFileSync(await file.path(), "latin1") };
}
