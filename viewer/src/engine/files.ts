/** Files of the page: they lie beside it, or inside it where the page is a single document. */

import coreAddress from "../core/worker.ts?worker&url";
import filesAddress from "../picture/files.ts?worker&url";
import { Unreachable } from "../refusal";

/** Workers: where they lie, and their files in the page. */
const WORKERS = {
  core: { address: coreAddress, path: "assets/worker.js" },
  files: { address: filesAddress, path: "assets/files.js" },
};

const read = new Map<string, Record<string, string> | null>();

/** Texts by the paths of files, which Python wrote into an element of the document. */
function listed(id: "files" | "versions"): Record<string, string> | null {
  if (!read.has(id)) {
    const element = document.getElementById(id);
    read.set(id, element && JSON.parse(element.textContent));
  }
  return read.get(id)!;
}

/** Whether the page is a single document, which has no address of its own. */
export function isDocument(): boolean {
  return listed("files") !== null;
}

/** The content of a file has its version in its address, so that a browser may keep it. */
function versionOf(path: string): string {
  return `?${listed("versions")?.[path] ?? ""}`;
}

/**
 * The content of a file by its path relative to the page; null: there is none.
 *
 * @throws Unreachable
 */
export async function readFile(path: string): Promise<Uint8Array<ArrayBuffer> | null> {
  const packed = listed("files");
  if (packed === null) {
    try {
      const answer = await fetch(path + versionOf(path));
      if (answer.ok) return new Uint8Array(await answer.arrayBuffer());
      if (answer.status === 404) return null;
    } catch {} // There is no answer, or it ends too early.
    throw new Unreachable(path);
  }
  // The document has each file by gzip (RFC 1952) and in base64.
  const text = packed[path];
  if (text === undefined) return null;
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const whole = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(whole).arrayBuffer());
}

/** A worker, and a promise that fails if it does not start. */
export async function startWorker(
  name: keyof typeof WORKERS,
): Promise<{ worker: Worker; broken: Promise<never> }> {
  const { address, path } = WORKERS[name];
  let worker: Worker;
  if (isDocument()) {
    const code = await readFile(path);
    const inside = URL.createObjectURL(new Blob([code!], { type: "text/javascript" }));
    // A document that is opened as a file may start no module from inside; the code is one file.
    worker = new Worker(inside);
    // Its first answer shows that the code has been read.
    worker.addEventListener("message", () => URL.revokeObjectURL(inside), { once: true });
  } else {
    worker = new Worker(address + versionOf(path), { type: "module" });
  }
  const broken = new Promise<never>((_resolve, reject) => {
    worker.addEventListener("error", () => reject(new Unreachable(path)));
  });
  return { worker, broken };
}
