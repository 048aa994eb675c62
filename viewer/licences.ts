/** The licences of the packages whose code is in the built page, which must go with it. */

import { readdirSync, readFileSync } from "node:fs";
import type { Plugin } from "vite";

const PACKAGES = ["preact", "@preact/signals", "@preact/signals-core", "three", "fflate"];

/** A package's name and the text of its licence. */
function licenceOf(name: string): string {
  const folder = `node_modules/${name}`;
  const file = readdirSync(folder).find((path) => /^licen[cs]e/i.test(path));
  if (file === undefined) throw new Error(`the package ${name} has no licence`);
  return `${name}\n\n${readFileSync(`${folder}/${file}`, "utf8").trim()}`;
}

/** The notices of TinyEXR and OpenEXR, from which code of three.js comes. */
function exrNotices(): string {
  const code = readFileSync("node_modules/three/examples/jsm/loaders/EXRLoader.js", "utf8");
  const notices = /^\/\/ \/\*[\s\S]*?^(?=\/\/ \/\/ End of OpenEXR license)/m.exec(code);
  if (notices === null) throw new Error("three.js has no notices of OpenEXR");
  return notices[0].replace(/^\/[/ *]*/gm, "").trim();
}

/** Writes the licences beside the built page. */
export function licences(): Plugin {
  return {
    name: "licences",
    generateBundle() {
      const source = [...PACKAGES.map(licenceOf), exrNotices()].join("\n\n\n");
      this.emitFile({ type: "asset", fileName: "licences.txt", source: `${source}\n` });
    },
  };
}
