/** Files of the page: they lie beside it, or inside it where the page is a single document. */

/** Files by their paths, each by gzip (RFC 1952) and in base64. */
type Packed = Record<string, string>;

let packed: Packed | null | undefined;

function packedFiles(): Packed | null {
  if (packed === undefined) {
    const element = document.getElementById("files");
    packed = element === null ? null : (JSON.parse(element.textContent) as Packed);
  }
  return packed;
}

/** Whether the page is a single document, which has no address of its own. */
export function isDocument(): boolean {
  return packedFiles() !== null;
}

/** The content of a file by its path relative to the page; null: there is none. */
export async function readFile(path: string): Promise<Uint8Array<ArrayBuffer> | null> {
  const inside = packedFiles();
  if (inside === null) {
    const answer = await fetch(path);
    return answer.ok ? new Uint8Array(await answer.arrayBuffer()) : null;
  }
  const text = inside[path];
  if (text === undefined) return null;
  const bytes = Uint8Array.from(atob(text), (character) => character.charCodeAt(0));
  const whole = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(whole).arrayBuffer());
}

/** The worker with the numeric core. */
export async function startWorker(): Promise<Worker> {
  if (!isDocument())
    return new Worker(new URL("../core/worker.ts", import.meta.url), { type: "module" });
  const code = await readFile("assets/worker.js");
  // A document that is opened as a file may start no module from inside; the code is one file.
  return new Worker(URL.createObjectURL(new Blob([code ?? ""], { type: "text/javascript" })));
}
