/** Files that are dropped on the page or opened: a panorama, a state, or a material. */

import { readHdr, withoutLights } from "../picture/panorama";
import { Refusal, readState } from "../state/read";
import { change, changeMaterial, notice } from "../state/store";
import { readMaterialFile } from "./material_file";
import { session, useEnvironment } from "./session";

/** Take over a file; what is wrong with it is told in one sentence. */
export async function openFile(file: File): Promise<void> {
  try {
    notice.value = "";
    const bytes = new Uint8Array(await file.arrayBuffer());
    const suffix = file.name.toLowerCase().split(".").pop();
    if (suffix === "hdr") {
      useEnvironment({ name: file.name, ...withoutLights(readHdr(bytes)) });
    } else if (suffix === "json") {
      change(readState(parsed(bytes)));
    } else if (suffix === "safetensors") {
      const core = session.value?.core;
      if (core === undefined) throw new Refusal("The networks are not loaded yet.");
      const bottom = readMaterialFile(bytes, core);
      const name = file.name.replace(/\.safetensors$/i, "").slice(0, 80);
      changeMaterial({ name, bottom, coats: [], solo: null });
    } else {
      throw new Refusal(
        "The page opens materials (.safetensors), panoramas (.hdr) and saved states (.json).",
      );
    }
  } catch (error) {
    if (!(error instanceof Refusal)) throw error;
    notice.value = `“${file.name}” was not opened. ${error.message}`;
  }
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
    const file = event.dataTransfer?.files[0];
    if (file) void openFile(file);
  });
}

function parsed(bytes: Uint8Array): unknown {
  try {
    return JSON.parse(new TextDecoder("utf-8", { fatal: true }).decode(bytes));
  } catch {
    throw new Refusal("It is no JSON text.");
  }
}
