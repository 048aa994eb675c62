/** What the tooltips say, also by touch and by the keyboard: "?" explains what has been tapped or focused. */

import { signal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { IconButton } from "./Button";

/** Whether the page explains, and what it says. */
const explains = signal(false);
const explained = signal("");

const FIRST = "Tap, point at or focus anything: its explanation appears here.";

/** The tooltip at an element: its own, that of what it is in, or that of a field's name. */
function tipOf(element: Element): string {
  const found = element.closest("[title], .field");
  const titled = found?.hasAttribute("title") ? found : found?.querySelector(".label");
  return titled?.getAttribute("title") ?? "";
}

export function HelpButton() {
  return (
    <IconButton
      class="help"
      name="Explain the page"
      title="Explains what you tap, point at or focus"
      pressed={explains.value}
      onClick={() => {
        explains.value = !explains.value;
        explained.value = FIRST;
      }}
    >
      ?
    </IconButton>
  );
}

export function Explanation() {
  useEffect(() => {
    const follow = ({ target }: Event) => {
      if (explains.value && target instanceof Element) explained.value = tipOf(target) || FIRST;
    };
    const end = new AbortController();
    for (const name of ["pointerover", "pointerdown", "focusin"])
      document.addEventListener(name, follow, { signal: end.signal });
    return () => end.abort();
  }, []);
  return (
    <p class="explanation" role="status" hidden={!explains.value}>
      {explains.value && explained.value}
    </p>
  );
}
