/** Object, light, exposure and comparison, under the picture. */

import { COMPARISONS, type Comparison, ENVIRONMENTS, OBJECTS, type State } from "../state/state";
import { change, state } from "../state/store";
import { Choice, Segments } from "./Choice";
import { Dial } from "./Dial";

const COMPARISON_NAMES: Record<Comparison, string> = {
  off: "Single",
  side: "Side by side",
  swipe: "Swipe",
  difference: "Difference",
};

export function Toolbar() {
  const { object, mesh, environment, panorama, rotation, exposure, comparison } = state.value;
  const objects: State["object"][] = mesh === "" ? [...OBJECTS] : [...OBJECTS, "own"];
  const environments = ENVIRONMENTS.filter((name) => name !== "own" || panorama !== "");
  return (
    <div class="toolbar" role="toolbar" aria-label="Scene">
      <label>
        <span>Object</span>
        <Choice
          value={object}
          options={objects.map((name) => [name, name === "own" ? mesh : capital(name)])}
          onChange={(name) => change({ object: name })}
        />
      </label>
      <label>
        <span>Light</span>
        <Choice
          value={environment}
          options={environments.map((name) => [name, name === "own" ? panorama : capital(name)])}
          onChange={(name) => change({ environment: name })}
        />
      </label>
      <Dial
        label="Turn"
        hint="Turns the light about the object. Double click: reset."
        text={`${Math.round(rotation)}°`}
        value={rotation}
        low={-180}
        high={180}
        step={1}
        onInput={(value) => change({ rotation: value }, "rotation")}
      />
      <Dial
        label="Exposure"
        hint="Brightness of the picture in powers of two. Double click: reset."
        text={`${exposure > 0 ? "+" : ""}${exposure}`}
        value={exposure}
        low={-4}
        high={4}
        step={0.1}
        onInput={(value) => change({ exposure: Number(value.toFixed(1)) }, "exposure")}
      />
      <Segments
        name="Compare"
        value={comparison}
        options={COMPARISONS.map((name) => [name, COMPARISON_NAMES[name]])}
        onChange={(name) => change({ comparison: name })}
      />
    </div>
  );
}

function capital(name: string): string {
  return name[0].toUpperCase() + name.slice(1);
}
