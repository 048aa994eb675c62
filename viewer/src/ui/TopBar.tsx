/** Presets, undo and redo, opening and saving. */

import { useRef } from "preact/hooks";
import { openFiles } from "../engine/open";
import { titleOf } from "../material/presets";
import { canRedo, canUndo, material, redo, state, undo } from "../state/store";
import { Button, IconButton } from "./Button";
import { HelpButton } from "./Help";
import { Icon, type IconName } from "./icons";
import { Menu } from "./Menu";
import { Presets } from "./Presets";
import { SaveMenu } from "./SaveMenu";
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
      <IconButton
        name="Undo"
        title="Undo (Ctrl+Z)"
        icon="undo"
        aria-disabled={!canUndo.value}
        onClick={undo}
      />
      <IconButton
        name="Redo"
        title="Redo (Ctrl+Shift+Z)"
        icon="redo"
        aria-disabled={!canRedo.value}
        onClick={redo}
      />
      <input
        ref={input}
        type="file"
        hidden
        multiple
        accept=".hdr,.exr,.obj,.glb,.gltf,.ply,.json,.safetensors"
        onChange={(event) => {
          void openFiles([...(event.currentTarget.files ?? [])]);
          event.currentTarget.value = "";
        }}
      />
      <Button
        class="text-button"
        aria-label="Open"
        title="A material (.safetensors), a panorama (.hdr, .exr), a mesh (.obj, .glb, .gltf, .ply) or a saved state (.json); or drop it on the page"
        onClick={() => input.current?.click()}
      >
        {labelled("open", "Open")}
      </Button>
      <Menu kind="view" name="View" label={labelled("sliders", "View")}>
        {(close) => <ViewMenu onDone={close} />}
      </Menu>
      <Menu kind="save" name="Save" label={labelled("save", "Save")}>
        {(close) => <SaveMenu onDone={close} />}
      </Menu>
      <HelpButton />
    </header>
  );
}

function labelled(icon: IconName, text: string) {
  return (
    <>
      <Icon name={icon} />
      <span>{text}</span>
    </>
  );
}
