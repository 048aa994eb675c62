/** A parameter: a slider and a number for one value or for each channel, or a colour. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import type { Channels } from "../core/api";
import { COLOURS, each, joined, type Rgb, rgb } from "../material/channels";
import { fromHex, hex } from "../material/colour";
import {
  type Parameter,
  rounded,
  STEPS,
  stepOf,
  valueAt,
  valueBeyond,
} from "../material/parameters";
import { Button } from "./Button";
import { NumberField } from "./NumberField";
import { Slider } from "./Slider";

interface FieldProps {
  /** What the parameter belongs to, for screen readers. */
  owner: string;
  parameter: Parameter;
  value: Channels;
  /** Whether the value may differ between the channels. */
  coloured: boolean;
  /** What stands at the end of its first line. */
  aside?: ComponentChildren;
  /** The colour of a value, which the sliders' tracks show. */
  colourOf?: ((value: Channels) => Rgb) | undefined;
  onChange: (value: Channels, kind: string) => void;
}

/** Places of a slider at which its track's colour is computed. */
const STOPS = [0, 0.2, 0.4, 0.6, 0.8, 1];

export function Field(props: FieldProps) {
  const { owner, parameter, value, coloured, aside, colourOf, onChange } = props;
  const { isColour = false } = parameter;
  const values = rgb(value);
  const name = `${owner}, ${parameter.label}`;
  const isUnfolded = useSignal(false);
  const split = isColour ? isUnfolded.value : typeof value !== "number";
  const reset = () => onChange(parameter.fallback, "");
  const set = (channel: number | null, next: number) => {
    if (channel === null) return onChange(next, name);
    const changed = [...values] as [number, number, number];
    changed[channel] = next;
    onChange(isColour ? joined(changed) : changed, `${name} ${channel}`);
  };
  const toggle = () => {
    if (isColour) isUnfolded.value = !isUnfolded.value;
    else onChange(split ? rounded((values[0] + values[1] + values[2]) / 3) : [...values], "");
  };

  /** A track's gradient: what a channel's values, or the one value, look like. */
  const gradient = (channel: number | null) => {
    if (colourOf === undefined) return undefined;
    const stops = STOPS.map((place) => {
      const other = valueAt(parameter, place);
      if (channel === null) return hex(colourOf(other));
      return hex(colourOf(each((k) => (k === channel ? other : values[k]))));
    });
    return `linear-gradient(90deg, ${stops.join(", ")})`;
  };
  const row = (channel: number | null) => {
    const own = channel === null ? name : `${name}, ${COLOURS[channel]}`;
    const shown = values[channel ?? 0];
    return (
      <div class="row" key={channel}>
        <Slider
          class={channel === null ? "" : COLOURS[channel]}
          track={gradient(channel)}
          name={own}
          text={String(shown)}
          low={0}
          high={STEPS}
          step={1}
          value={stepOf(parameter, shown)}
          onInput={(step) => set(channel, valueBeyond(parameter, step, shown))}
          onReset={reset}
        />
        <NumberField
          name={`${own}, number`}
          value={shown}
          low={parameter.low}
          high={parameter.high}
          onChange={(next) => set(channel, next)}
        />
      </div>
    );
  };

  return (
    <div class={split ? "field split" : "field"}>
      {/* biome-ignore lint/a11y/noStaticElementInteractions: a shortcut; the menu key is Delete on the slider */}
      <span class="label" title={`${parameter.hint} Double click: reset.`} onDblClick={reset}>
        {parameter.label}
      </span>
      <span class="aside">
        {aside}
        {coloured && (
          <Button
            class="channels"
            aria-pressed={isColour ? undefined : split}
            aria-expanded={isColour ? split : undefined}
            aria-label={isColour ? `${name}: channels` : `${name}: one value for each colour`}
            title={isColour ? "The channels" : "One value for all colours, or for each"}
            onClick={toggle}
          >
            <i />
            <i />
            <i />
          </Button>
        )}
      </span>
      <div class="rows">
        {isColour && (
          <input
            type="color"
            class="swatch"
            aria-label={`${name}: choose`}
            title="Choose the colour"
            value={hex(values)}
            onInput={({ currentTarget }) =>
              onChange(joined(fromHex(currentTarget.value)), `${name} colour`)
            }
          />
        )}
        {split ? [0, 1, 2].map(row) : !isColour && row(null)}
      </div>
    </div>
  );
}
