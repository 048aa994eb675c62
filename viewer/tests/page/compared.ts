/** Saves what the page shows, renders it in Mitsuba, and compares the pictures. */

import { execFileSync, spawnSync } from "node:child_process";
import { mkdirSync, writeFileSync } from "node:fs";
import { join } from "node:path";
import type { Page } from "@playwright/test";

/** See `mitsuba_picture.py`. */
export interface Measures {
  flip: number;
  noise: number;
  mean: number;
  mean_noise: number;
  tone: number;
}

export const PYTHON = process.env.PYTHON ?? join(import.meta.dirname, "../../../.venv/bin/python");
const FOLDER = join(import.meta.dirname, "../../out/mitsuba");

export const hasFlip = spawnSync(PYTHON, ["-c", "import flip_evaluator"]).status === 0;

/** The measures of the page's picture; name: of the files that are left in `out/mitsuba`. */
export async function compared(page: Page, name: string): Promise<Measures> {
  mkdirSync(FOLDER, { recursive: true });
  await save(page, "Radiance", `${name}.exr`);
  await save(page, "Mitsuba scene", `${name}.zip`);
  await save(page, "Picture", `${name}.png`);
  const script = join(import.meta.dirname, "mitsuba_picture.py");
  const text = execFileSync(PYTHON, [script, FOLDER, name], { encoding: "utf8" });
  writeFileSync(join(FOLDER, `${name}.json`), text);
  return JSON.parse(text) as Measures;
}

async function save(page: Page, label: string, name: string): Promise<void> {
  await page.getByRole("button", { name: "Save", exact: true }).click();
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: new RegExp(`^${label}`) }).click();
  await (await download).saveAs(join(FOLDER, name));
}
