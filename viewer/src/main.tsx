/** Starts the page. */

import { effect } from "@preact/signals";
import { render } from "preact";
import { isDocument } from "./engine/files";
import { acceptDrops } from "./engine/open";
import { begin, ownEnvironment } from "./engine/session";
import { fromAddress, toAddress } from "./state/address";
import { begunWith, redo, state, undo } from "./state/store";
import { App } from "./ui/App";
import "./style.css";

const addressed = location.hash.length > 1;
if (addressed) readAddress();

function readAddress(): void {
  begunWith(() => {
    const read = fromAddress(location.hash);
    const own = read.environment === "own" && ownEnvironment.value === null;
    return own ? { ...read, environment: "studio" } : read;
  });
}

// The address follows the state, but not at every step of a slider. A document in a frame has none.
let written = location.hash;
let timer = 0;
effect(() => {
  const present = state.value;
  if (isDocument()) return;
  clearTimeout(timer);
  timer = window.setTimeout(() => {
    written = `#${toAddress(present)}`;
    history.replaceState(null, "", written);
  }, 300);
});
window.addEventListener("hashchange", () => {
  if (location.hash !== written) readAddress();
});

window.addEventListener("keydown", (event) => {
  if (!(event.ctrlKey || event.metaKey) || event.key.toLowerCase() !== "z") {
    if (!(event.ctrlKey && event.key.toLowerCase() === "y")) return;
    event.preventDefault();
    return redo();
  }
  event.preventDefault();
  if (event.shiftKey) redo();
  else undo();
});

acceptDrops(document.documentElement);
render(<App />, document.getElementById("page")!);
void begin(addressed);
