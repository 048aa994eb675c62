/** Starts the page. */

import { effect } from "@preact/signals";
import { render } from "preact";
import { isDocument } from "./engine/files";
import { acceptDrops } from "./engine/open";
import { begin } from "./engine/session";
import { titleOf } from "./material/presets";
import { fromAddress, toAddress } from "./state/address";
import { complain, material, redo, showRead, state, undo } from "./state/store";
import { App } from "./ui/App";
import { keepFocus } from "./ui/focus";
import "./style.css";

/** Whether the address holds a state; one without says nothing. */
const isAddressed = () => location.hash.length > 1;
const addressed = isAddressed();
if (addressed) showRead(() => fromAddress(location.hash), false);

// The address follows the state, but not at every step: browsers allow few changes in a second.
// A document in a frame has none.
let written = location.hash;
let timer = 0;
effect(() => {
  state.value;
  if (isDocument() || timer !== 0) return;
  timer = window.setTimeout(() => {
    timer = 0;
    written = `#${toAddress(state.peek())}`;
    history.replaceState(null, "", written);
  }, 400);
});
effect(() => {
  document.title = `${titleOf(material.value)} · Urushi`;
});
window.addEventListener("hashchange", () => {
  if (isAddressed() && location.hash !== written) showRead(() => fromAddress(location.hash), true);
});

window.addEventListener("keydown", (event) => {
  const key = event.ctrlKey || event.metaKey ? event.key.toLowerCase() : "";
  const isText =
    event.target instanceof HTMLInputElement && ["text", "search"].includes(event.target.type);
  if (isText || (key !== "z" && key !== "y")) return; // a text has an undo of its own
  event.preventDefault();
  if (key === "y" || event.shiftKey) redo();
  else undo();
});

window.addEventListener("unhandledrejection", (event) => complain(event.reason));

acceptDrops(document.documentElement);
keepFocus();
const page = document.getElementById("page")!;
page.replaceChildren(); // the sentence for browsers that refuse this script
render(<App />, page);
void begin(addressed);
