/** Python beside the tests: that of the project, or of `PYTHON`. */

import { execFileSync } from "node:child_process";
import { existsSync } from "node:fs";
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
