/** A digest of what the page is built from, by which a test finds a build that is out of date. */

import { createHash } from "node:crypto";
import { readdirSync, readFileSync } from "node:fs";
import type { Plugin } from "vite";

const FOLDERS = ["src", "public"];
const FILES = ["index.html", "package-lock.json", "vite.config.ts"];

/** SHA-256 of all paths and contents, sorted by path. */
function digest(): string {
  const found = FOLDERS.flatMap((folder) =>
    readdirSync(folder, { recursive: true, withFileTypes: true })
      .filter((entry) => entry.isFile())
      .map((entry) => `${entry.parentPath}/${entry.name}`),
  );
  const hash = createHash("sha256");
  for (const path of [...found, ...FILES].sort())
    hash.update(`${path}\0`).update(readFileSync(path)).update("\0");
  return hash.digest("hex");
}

/** Writes the digest beside the built page. */
export function sources(): Plugin {
  return {
    name: "sources",
    generateBundle() {
      this.emitFile({ type: "asset", fileName: "sources.txt", source: `${digest()}\n` });
    },
  };
}
