/** The page. */

import { announcement, change, state } from "../state/store";
import { Cards } from "./Cards";
import { Plots } from "./Plots";
import { Stage } from "./Stage";
import { Toolbar } from "./Toolbar";
import { TopBar } from "./TopBar";

export function App() {
  return (
    <>
      <TopBar />
      <main>
        <Stage />
        <Toolbar />
        <div class="column">
          <aside aria-label="Material">
            {state.value.comparison !== "off" && <Chooser />}
            <Cards />
          </aside>
          <Plots />
        </div>
      </main>
      <p class="spoken" role="status">
        {announcement.value}
      </p>
    </>
  );
}

/** Which of the two materials the cards show. */
function Chooser() {
  const { active, materials } = state.value;
  return (
    <div class="segments chooser" role="group" aria-label="Material on the cards">
      {([0, 1] as const).map((slot) => (
        <button
          key={slot}
          type="button"
          aria-pressed={active === slot}
          onClick={() => change({ ...state.value, active: slot })}
        >
          <b>{slot === 0 ? "A" : "B"}</b> {materials[slot].name}
        </button>
      ))}
    </div>
  );
}
