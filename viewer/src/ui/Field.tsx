/** A parameter: a slider and a number for one value or for each channel, and a colour. */

import type { ComponentChildren } from "preact";
import type { Channels } from "../core/api";
import { depthOf, fromHex, hex, transmission } from "../material/colour";
import { joined, type Rgb, rgb } from "../material/material";
import { clamped, type Parameter, placeOf, rounded, valueAt } from "../material/parameters";
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
  onChange: (value: Channels, kind: string) => void;
}

const CHANNELS = ["red", "green", "blue"] as const;

export function Field({ owner, parameter, value, coloured, aside, onChange }: FieldProps) {
  const split = typeof value !== "number";
  const values = rgb(value);
  const name = `${owner}, ${parameter.label}`;
  const reset = () => onChange(parameter.fallback, "");
  const set = (channel: number | null, next: number) => {
    if (channel === null) return onChange(next, name);
    const changed = [...values] as [number, number, number];
    changed[channel] = next;
    onChange(changed, `${name} ${channel}`);
  };
  const toggle = () =>
    onChange(split ? rounded((values[0] + values[1] + values[2]) / 3) : [...values], "");

  return (
    <div class={split ? "field split" : "field"}>
      {/* biome-ignore lint/a11y/noStaticElementInteractions: a shortcut; the menu key is Delete on the slider */}
      <span class="label" title={`${parameter.hint} Double click: reset.`} onDblClick={reset}>
        {parameter.label}
      </span>
      <span class="aside">
        {aside}
        {parameter.colour && (
          <Swatch name={name} parameter={parameter} values={values} onChange={onChange} />
        )}
        {coloured && (
          <button
            type="button"
            class="channels"
            aria-pressed={split}
            aria-label={`${name}: one value for each colour`}
            title={split ? "One value for all colours" : "One value for each colour"}
            onClick={toggle}
          >
            <i />
            <i />
            <i />
          </button>
        )}
      </span>
      <div class="rows">
        {split ? (
          CHANNELS.map((channel, at) => (
            <Row
              key={channel}
              name={`${name}, ${channel}`}
              channel={channel}
              parameter={parameter}
              value={values[at]!}
              onInput={(next) => set(at, next)}
              onReset={reset}
            />
          ))
        ) : (
          <Row
            name={name}
            parameter={parameter}
            value={values[0]}
            onInput={(next) => set(null, next)}
            onReset={reset}
          />
        )}
      </div>
    </div>
  );
}

interface RowProps {
  name: string;
  channel?: string;
  parameter: Parameter;
  value: number;
  onInput: (value: number) => void;
  onReset: () => void;
}

/** Steps of a slider. */
const STEPS = 500;

function Row({ name, channel, parameter, value, onInput, onReset }: RowProps) {
  return (
    <div class="row">
      <Slider
        class={channel ?? ""}
        name={name}
        text={String(value)}
        low={0}
        high={STEPS}
        step={1}
        value={Math.round(placeOf(parameter, value) * STEPS)}
        onInput={(place) => onInput(valueAt(parameter, place / STEPS))}
        onReset={onReset}
      />
      <NumberField
        name={`${name}, number`}
        value={value}
        low={parameter.low}
        high={parameter.high}
        onChange={(next) => onInput(clamped(parameter, next))}
      />
    </div>
  );
}

interface SwatchProps {
  name: string;
  parameter: Parameter;
  values: Rgb;
  onChange: (value: Channels, kind: string) => void;
}

function Swatch({ name, parameter, values, onChange }: SwatchProps) {
  const depth = parameter.colour === "depth";
  const shown = depth ? transmission(values) : values;
  return (
    <input
      type="color"
      class="swatch"
      aria-label={depth ? `${name}: colour that passes the medium` : `${name}: colour`}
      title={depth ? "The colour that passes once through the medium" : "The colour"}
      value={hex(shown)}
      onInput={(event) => {
        const colour = fromHex(event.currentTarget.value);
        onChange(joined(depth ? depthOf(colour) : colour), `${name} colour`);
      }}
    />
  );
}
