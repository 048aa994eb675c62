/** The page. */

import { Fragment } from "preact";
import { titleOf } from "../material/presets";
import type { State } from "../state/state";
import { announce, announcement, change, changeMaterial, material, state } from "../state/store";
import { Button } from "./Button";
import { Cards } from "./Cards";
import { Segments } from "./Choice";
import { Explanation } from "./Help";
import { Icon } from "./icons";
import { Plots } from "./Plots";
import { Stage } from "./Stage";
import { Toolbar } from "./Toolbar";
import { TopBar } from "./TopBar";

export function App() {
  return (
    <>
      <Button class="skip" onClick={() => document.getElementById("material")?.focus()}>
        Skip to the layers
      </Button>
      <TopBar />
      <main>
        <Stage />
        <Toolbar />
        <div class="column">
          <aside id="material" tabIndex={-1} aria-label="Material">
            {state.value.comparison !== "off" && <Chooser />}
            <Name />
            <Cards />
          </aside>
          <Plots />
        </div>
      </main>
      <Explanation />
      <p class="spoken" role="status">
        {announcement.value}
      </p>
    </>
  );
}

/** The name of the material on the cards, which can be changed. */
function Name() {
  const { name } = material.value;
  return (
    <input
      type="text"
      class="name"
      aria-label="Name of the material"
      maxLength={80}
      autocomplete="off"
      spellcheck={false}
      value={name}
      onChange={({ currentTarget: field }) => {
        const next = field.value.trim();
        if (next === "") field.value = name;
        else if (next !== name) changeMaterial({ ...material.value, name: next });
      }}
      onKeyDown={({ key, currentTarget }) => {
        if (key === "Enter") currentTarget.blur();
      }}
    />
  );
}

/** Which of the two materials the cards show, and what makes one of the other. */
function Chooser() {
  const { active, materials } = state.value;
  const [first, second] = materials;
  const other = active === 0 ? "B" : "A";
  const set = (next: State["materials"], said: string) => {
    change({ materials: next });
    announce(said);
  };
  const copied = materials[active];
  return (
    <>
      <Segments
        name="Material on the cards"
        value={active}
        options={([0, 1] as const).map((slot) => [
          slot,
          <Fragment key={slot}>
            <b>{"AB"[slot]}</b> {titleOf(materials[slot])}
          </Fragment>,
        ])}
        onChange={(slot) => change({ active: slot })}
      />
      <div class="pair">
        <Button
          class="quiet"
          onClick={() => set([copied, copied], `The material was copied to ${other}.`)}
        >
          Copy to {other}
        </Button>
        <Button class="quiet" onClick={() => set([second, first], "A and B were swapped.")}>
          <Icon name="swap" /> Swap
        </Button>
      </div>
    </>
  );
}
