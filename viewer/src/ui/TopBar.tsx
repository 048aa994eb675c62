/** Presets, undo and redo, opening and saving. */

import { useEffect, useRef } from "preact/hooks";
import { opened, openFiles } from "../engine/open";
import { readStored, stored } from "../engine/session";
import { PRESETS, titleOf } from "../material/presets";
import { canRedo, canUndo, changeMaterial, material, redo, state, undo } from "../state/store";
import { HelpButton } from "./Help";
import { Icon } from "./icons";
import { Menu } from "./Menu";
import { SaveMenu } from "./SaveMenu";
import { Thumbnail } from "./Thumbnail";
import { ViewMenu } from "./ViewMenu";

export function TopBar() {
  const input = useRef<HTMLInputElement>(null);
  const { comparison, active } = state.value;
  const badge = comparison === "off" ? "" : "AB"[active];
  return (
    <header class="top">
      <h1>
        <svg viewBox="0 0 20 20" aria-hidden="true">
          <path d="M3 13.5 10 17l7-3.5M3 10l7 3.5L17 10" />
          <path class="lacquer" d="m10 3 7 3.5-7 3.5-7-3.5Z" />
        </svg>
        Urushi
      </h1>
      <Menu
        kind="presets"
        name={`Material ${badge} ${titleOf(material.value)}: choose another`}
        label={
          <>
            {badge && <b class="badge">{badge}</b>}{" "}
            <span class="current">{titleOf(material.value)}</span>
            <Icon name="down" />
          </>
        }
      >
        {(close) => <Presets onChosen={close} />}
      </Menu>
      <span class="spacer" />
      <button
        type="button"
        class="icon-button"
        aria-label="Undo"
        title="Undo (Ctrl+Z)"
        aria-disabled={!canUndo.value}
        onClick={undo}
      >
        <Icon name="undo" />
      </button>
      <button
        type="button"
        class="icon-button"
        aria-label="Redo"
        title="Redo (Ctrl+Shift+Z)"
        aria-disabled={!canRedo.value}
        onClick={redo}
      >
        <Icon name="redo" />
      </button>
      <input
        ref={input}
        type="file"
        hidden
        multiple
        accept=".hdr,.exr,.obj,.glb,.gltf,.ply,.json,.safetensors,.mtlx,.binary,.bsdf"
        onChange={(event) => {
          void openFiles([...(event.currentTarget.files ?? [])]);
          event.currentTarget.value = "";
        }}
      />
      <button
        type="button"
        class="text-button"
        aria-label="Open"
        title="A material (.safetensors, .mtlx), a measured BRDF (.binary, .bsdf), a panorama (.hdr, .exr), a mesh (.obj, .glb, .gltf) or a saved state (.json); or drop it on the page"
        onClick={() => input.current?.click()}
      >
        <Icon name="open" />
        <span>Open</span>
      </button>
      <Menu
        kind="view"
        name="View"
        label={
          <>
            <Icon name="sliders" />
            <span>View</span>
          </>
        }
      >
        {(close) => <ViewMenu onDone={close} />}
      </Menu>
      <Menu
        kind="save"
        name="Save"
        label={
          <>
            <Icon name="save" />
            <span>Save</span>
          </>
        }
      >
        {(close) => <SaveMenu onDone={close} />}
      </Menu>
      <HelpButton />
    </header>
  );
}

/**
 * The materials that were opened, the library, and what lies beside the page, as small pictures.
 *
 * One of them is a stop of the Tab key; arrows, Home, End, and typed letters choose another.
 */
function Presets({ onChosen }: { onChosen: () => void }) {
  const list = useRef<HTMLUListElement>(null);
  const typed = useRef({ text: "", time: 0 });
  const present = () => list.current?.querySelector<HTMLElement>("[tabindex='0']");
  useEffect(() => {
    void readStored();
    present()?.focus();
  }, []);
  const all = [...opened.value, ...PRESETS, ...stored.value];
  const chosen = Math.max(
    all.findIndex(({ name }) => name === material.value.name),
    0,
  );
  const onKeyDown = (event: KeyboardEvent) => {
    const buttons = [...(list.current?.querySelectorAll("button") ?? [])];
    const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
    const row = buttons.filter(({ offsetTop }) => offsetTop === buttons[0]?.offsetTop).length;
    const { key, timeStamp } = event;
    const step = { ArrowLeft: -1, ArrowRight: 1, ArrowUp: -row, ArrowDown: row }[key];
    let next = step === undefined ? -1 : at + step;
    if (key === "Home") next = 0;
    if (key === "End") next = buttons.length - 1;
    if (key.length === 1 && key !== " " && !event.ctrlKey && !event.metaKey) {
      const text = timeStamp < typed.current.time + 700 ? typed.current.text + key : key;
      typed.current = { text, time: timeStamp };
      next = all.findIndex(({ name }) => name.toLowerCase().startsWith(text.toLowerCase()));
    } else if (next < 0 && step === undefined) return;
    event.preventDefault();
    buttons[next]?.focus();
  };
  return (
    <ul ref={list} onKeyDown={onKeyDown}>
      {all.map((preset, place) => (
        <li key={preset.name}>
          <button
            type="button"
            tabIndex={place === chosen ? 0 : -1}
            aria-pressed={preset.name === material.value.name}
            onClick={() => {
              changeMaterial(preset);
              onChosen();
            }}
          >
            <Thumbnail of={preset} />
            <span>{preset.name}</span>
          </button>
        </li>
      ))}
    </ul>
  );
}
