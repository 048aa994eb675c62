/** Python beside the tests: that of the project, or of `PYTHON`. */

import { execFileSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

export const PYTHON = process.env.PYTHON ?? join(import.meta.dirname, "../../.venv/bin/python");

/** False where only the page is worked at; `make test-page` sets it up. */
export const hasPython = existsSync(PYTHON);

/** What a program, or a script and its arguments, prints. */
export function python(...args: string[]): string {
  const [first, ...others] = args;
  const program = first!.includes("\n") ? ["-c", first!] : [first!];
  return execFileSync(PYTHON, [...program, ...others], { encoding: "utf8", maxBuffer: 2 ** 26 });
}

/** A folder that is removed when the tests end. */
export function folderOfTest(): string {
  const folder = mkdtempSync(join(tmpdir(), "urushi-"));
  process.on("exit", () => rmSync(folder, { recursive: true, force: true }));
  return folder;
}
