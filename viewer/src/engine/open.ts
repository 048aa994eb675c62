/** Files that are dropped on the page or opened: a panorama, a state, or a material. */

import { signal } from "@preact/signals";
import { TensorFile } from "../core/safetensors";
import type { BottomInAir, MaterialCards, TexelBottom } from "../material/material";
import { isTexture } from "../material/texture";
import { Refusal } from "../refusal";
import { text } from "../state/json";
import { readState } from "../state/read";
import { asTask, change, changeMaterial, complain, notice } from "../state/store";
import { readMaterialFile } from "./material_file";
import { keepTexture, useEnvironment, useMesh } from "./opened";
import { byOwnWorker, type Cores } from "./remote";
import { session } from "./session";

/** Suffixes of meshes. */
const MESHES = ["obj", "glb", "gltf", "ply"];

/** The materials of files that were opened, one of each name, the last first. */
export const opened = signal<readonly MaterialCards[]>([]);

/** Take over files, one after the other; what is wrong with one is told in one sentence. */
export async function openFiles(files: readonly File[]): Promise<void> {
  notice.value = null;
  for (const file of files) {
    try {
      await openFile(file);
    } catch (error) {
      complain(error, () => void openFiles([file]), `“${file.name}” was not opened. `);
    }
  }
}

async function openFile(file: File): Promise<void> {
  await bytesOf(file.slice(0, 1)); // a folder has none
  const suffix = file.name.toLowerCase().split(".").pop()!;
  if (suffix === "hdr" || suffix === "exr") {
    const bytes = await bytesOf(file);
    const own = await asTask("Reading the panorama", (end) =>
      byOwnWorker("readPanorama", [bytes, suffix], [bytes.buffer], end),
    );
    useEnvironment(file.name, { file, ...own });
  } else if (MESHES.includes(suffix)) {
    const bytes = await bytesOf(file);
    const mesh = await asTask("Reading the mesh", (end) =>
      byOwnWorker("readMesh", [bytes, suffix], [bytes.buffer], end),
    );
    useMesh(file.name, mesh);
  } else if (suffix === "json") {
    change(readState(parsed(await bytesOf(file))));
  } else if (suffix === "safetensors") {
    const cores = session.value?.cores;
    if (cores === undefined) throw new Refusal("The networks are not loaded yet.");
    const name = text("Material")(file.name.replace(/\.[a-z]+$/i, ""));
    const read = await materialOf(cores, await bytesOf(file));
    const material = { name, ...read, coats: [], solo: null };
    opened.value = [material, ...opened.value.filter((other) => other.name !== name)];
    changeMaterial(material);
  } else throw new Refusal(adviceOn(suffix, file.name));
}

/** What to do with a file that the page does not open. */
function adviceOn(suffix: string, name: string): string {
  if (suffix === "binary" || suffix === "bsdf")
    return `Python encodes measured BRDFs: run urushi view ${name}.`;
  if (suffix === "mtlx")
    return "Python reads MaterialX: run urushi convert, and urushi view with the scene that it writes.";
  return "The page opens materials (.safetensors), panoramas (.hdr, .exr), meshes (.obj, .glb, .gltf, .ply) and saved states (.json).";
}

async function bytesOf(file: Blob): Promise<Uint8Array<ArrayBuffer>> {
  try {
    return new Uint8Array(await file.arrayBuffer());
  } catch {
    throw new Refusal("It is a folder, or the browser cannot read it.");
  }
}

/** The material of a file: codes, or a texture of codes. */
async function materialOf(
  cores: Cores,
  bytes: Uint8Array<ArrayBuffer>,
): Promise<{ bottom: BottomInAir | TexelBottom; rotation?: number }> {
  const core = cores.isotropic;
  const file = new TensorFile(bytes);
  if (isTexture(file))
    return { bottom: { kind: "texels", texture: await keepTexture(bytes, core) } };
  const isOther = file.description.weights !== core.fingerprint;
  return readMaterialFile(file, isOther ? await cores.anisotropic() : core);
}

/** Open files that are dropped anywhere on the page. */
export function acceptDrops(page: HTMLElement): void {
  page.addEventListener("dragover", (event) => {
    event.preventDefault();
    page.classList.add("dropping");
  });
  page.addEventListener("dragleave", (event) => {
    if (event.relatedTarget === null) page.classList.remove("dropping");
  });
  page.addEventListener("drop", (event) => {
    event.preventDefault();
    page.classList.remove("dropping");
    const files = [...(event.dataTransfer?.files ?? [])];
    if (files.length > 0) void openFiles(files);
    else complain(new Refusal("What was dropped is no file; save it as a file, and drop that."));
  });
}

function parsed(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw new Refusal("It is no JSON text.");
  }
}
