/** Saves what the page shows, renders it in Mitsuba, and compares the pictures. */

import { type ChildProcess, spawn, spawnSync } from "node:child_process";
import { once } from "node:events";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Page } from "@playwright/test";
import { PYTHON } from "../python";
import { expect, saved } from "./page";

/** See `mitsuba_picture.py`. */
interface Measures {
  flip: number;
  noise: number;
  mean: number;
  mean_noise: number;
  tone: number;
}

const FOLDER = join(import.meta.dirname, "../../out/mitsuba");

export const hasFlip = spawnSync(PYTHON, ["-c", "import flip_evaluator"]).status === 0;

/** The process that renders all scenes, so that it starts once. */
let renderer: ChildProcess | undefined;

/** The page shows Mitsuba's picture; name: of the files that are left in `out/mitsuba`. */
export async function expectAlike(page: Page, name: string): Promise<Measures> {
  mkdirSync(FOLDER, { recursive: true });
  const kinds = { Radiance: "exr", "Mitsuba scene": "zip", Picture: "png" };
  for (const [label, suffix] of Object.entries(kinds))
    writeFileSync(join(FOLDER, `${name}.${suffix}`), (await saved(page, label)).text, "latin1");
  const script = join(import.meta.dirname, "mitsuba_picture.py");
  renderer ??= spawn(PYTHON, [script, FOLDER], { stdio: ["pipe", "pipe", "inherit"] });
  renderer.stdin!.write(`${name}\n`);
  // A line is short and comes at once; a process that fails ends its output.
  const [text] = await Promise.race([
    once(renderer.stdout!, "data"),
    once(renderer.stdout!, "end"),
  ]);
  if (text === undefined) {
    renderer = undefined;
    throw new Error("Rendering by Mitsuba failed; its error is printed above.");
  }
  writeFileSync(join(FOLDER, `${name}.json`), text);
  const measures = JSON.parse(String(text)) as Measures;
  expect.soft(measures.flip).toBeLessThan(0.05);
  expect.soft(Math.abs(measures.mean)).toBeLessThan(0.01);
  // Noise alone is far below these tolerances.
  expect.soft(measures.noise).toBeLessThan(0.02);
  expect.soft(Math.abs(measures.mean_noise)).toBeLessThan(0.003);
  return measures;
}
