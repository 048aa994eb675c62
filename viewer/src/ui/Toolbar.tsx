/** Object, light, exposure and comparison, under the picture. */

import { COMPARISONS, type Comparison, ENVIRONMENTS, OBJECTS, type State } from "../state/state";
import { change, state } from "../state/store";
import { Dial } from "./Dial";

const COMPARISON_NAMES: Record<Comparison, string> = {
  off: "Single",
  side: "Side by side",
  swipe: "Swipe",
  difference: "Difference",
};

export function Toolbar() {
  const { object, mesh, environment, panorama, rotation, exposure, comparison } = state.value;
  const set = (next: Partial<State>, kind = "") => change({ ...state.value, ...next }, kind);
  const objects = mesh === "" ? OBJECTS : ([...OBJECTS, "own"] as const);
  const environments = ENVIRONMENTS.filter((name) => name !== "own" || panorama !== "");
  return (
    <div class="toolbar" role="toolbar" aria-label="Scene">
      <label>
        <span>Object</span>
        <select
          value={object}
          onChange={(event) => set({ object: event.currentTarget.value as State["object"] })}
        >
          {objects.map((name) => (
            <option key={name} value={name}>
              {name === "own" ? mesh : capital(name)}
            </option>
          ))}
        </select>
      </label>
      <label>
        <span>Light</span>
        <select
          value={environment}
          onChange={(event) =>
            set({ environment: event.currentTarget.value as State["environment"] })
          }
        >
          {environments.map((name) => (
            <option key={name} value={name}>
              {name === "own" ? panorama : capital(name)}
            </option>
          ))}
        </select>
      </label>
      <Dial
        label="Turn"
        hint="Turns the light about the object. Double click: reset."
        text={`${Math.round(rotation)}°`}
        value={rotation}
        low={-180}
        high={180}
        step={1}
        onInput={(value) => set({ rotation: value }, "rotation")}
      />
      <Dial
        label="Exposure"
        hint="Brightness of the picture in powers of two. Double click: reset."
        text={`${exposure > 0 ? "+" : ""}${exposure}`}
        value={exposure}
        low={-4}
        high={4}
        step={0.1}
        onInput={(value) => set({ exposure: Number(value.toFixed(1)) }, "exposure")}
      />
      <div class="segments" role="group" aria-label="Compare">
        {COMPARISONS.map((name) => (
          <button
            key={name}
            type="button"
            aria-pressed={comparison === name}
            onClick={() => set({ comparison: name })}
          >
            {COMPARISON_NAMES[name]}
          </button>
        ))}
      </div>
    </div>
  );
}

function capital(name: string): string {
  return name[0]!.toUpperCase() + name.slice(1);
}
