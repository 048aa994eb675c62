/** The materials to choose from: those that were opened, the library, and what lies beside the page. */

import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { opened } from "../engine/open";
import { readStored, stored } from "../engine/session";
import { groupOf, PRESETS } from "../material/presets";
import { changeMaterial, material } from "../state/store";
import { Button } from "./Button";
import { Thumbnail } from "./Thumbnail";

/** One material is a stop of the Tab key; arrows, Home and End choose another, and letters search. */
export function Presets({ onChosen }: { onChosen: () => void }) {
  const root = useRef<HTMLDivElement>(null);
  const search = useRef<HTMLInputElement>(null);
  const sought = useSignal("");
  const focused = useSignal(material.value.name);
  useEffect(() => {
    void readStored();
    root.current?.querySelector<HTMLElement>("[tabindex='0']")?.focus();
  }, []);

  const all = [
    ...opened.value.map((one) => ["Opened", one] as const),
    ...PRESETS.map((one) => [groupOf(one), one] as const),
    ...stored.value.map((one) => ["Thin films", one] as const),
  ].filter(([, { name }]) => name.toLowerCase().includes(sought.value.toLowerCase()));
  const stop = all.find(([, { name }]) => name === focused.value) ?? all[0];
  const choose = (one: (typeof all)[number] | undefined) => {
    if (one === undefined) return;
    changeMaterial(one[1]);
    onChosen();
  };

  const onKeyDown = (event: KeyboardEvent) => {
    const { key } = event;
    const buttons = [...(root.current?.querySelectorAll("button") ?? [])];
    const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
    const beside = { ArrowLeft: -1, ArrowRight: 1 }[key];
    const down = { ArrowUp: -1, ArrowDown: 1 }[key];
    let next: HTMLElement | null | undefined;
    if (event.target === search.current) {
      if (key === "Enter") {
        event.preventDefault(); // the button that has the focus then would open the menu again
        choose(all[0]);
      } else if (down === 1) next = buttons[0];
    } else if (beside !== undefined) next = buttons[at + beside];
    else if (down !== undefined) next = nearest(buttons, buttons[at], down) ?? search.current;
    else if (key === "Home") next = buttons[0];
    else if (key === "End") next = buttons.at(-1);
    else if (key.length === 1 && key !== " " && !event.ctrlKey && !event.metaKey)
      return search.current!.focus(); // where the letter is then typed
    if (!next) return;
    event.preventDefault();
    next.focus();
  };
  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: keys of the buttons and of the field in it
    <div ref={root} onKeyDown={onKeyDown}>
      <input
        ref={search}
        type="search"
        class="search"
        placeholder="Search"
        aria-label="Search the materials"
        value={sought.value}
        onInput={({ currentTarget }) => {
          sought.value = currentTarget.value;
        }}
      />
      {[...new Set(all.map(([group]) => group))].map((group) => (
        <section key={group}>
          <h2>{group}</h2>
          <ul>
            {all
              .filter(([of]) => of === group)
              .map((one) => (
                <li key={one[1].name}>
                  <Button
                    tabIndex={one === stop ? 0 : -1}
                    aria-pressed={one[1].name === material.value.name}
                    onFocus={() => {
                      focused.value = one[1].name;
                    }}
                    onClick={() => choose(one)}
                  >
                    <Thumbnail of={one[1]} />
                    <span>{one[1].name}</span>
                  </Button>
                </li>
              ))}
          </ul>
        </section>
      ))}
      {all.length === 0 && <p class="note">No material has this in its name.</p>}
    </div>
  );
}

/** The nearest of elements in the next line above (-1) or below (1). */
function nearest(all: HTMLElement[], from: HTMLElement, way: number): HTMLElement | undefined {
  const { left, top } = from.getBoundingClientRect();
  const apart = (one: HTMLElement) => {
    const box = one.getBoundingClientRect();
    const down = way * (box.top - top);
    return down < 4 ? Infinity : 100 * down + Math.abs(box.left - left);
  };
  const next = all.reduce((a, b) => (apart(b) < apart(a) ? b : a), from);
  return apart(next) < Infinity ? next : undefined;
}
