/** A parameter: a slider and a number for one value or for each channel, and a colour. */

import type { ComponentChildren } from "preact";
import type { Channels } from "../core/api";
import { joined, type Rgb, rgb } from "../material/channels";
import { fromHex, hex } from "../material/colour";
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
  /** The colour of a value, which the sliders' tracks show. */
  colourOf?: ((value: Channels) => Rgb) | undefined;
  onChange: (value: Channels, kind: string) => void;
}

const CHANNELS = ["red", "green", "blue"] as const;

export function Field(props: FieldProps) {
  const { owner, parameter, value, coloured, aside, colourOf, onChange } = props;
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

  /** A track's gradient: what a channel's values, or the one value, look like. */
  const gradient = (channel: number | null) => {
    if (colourOf === undefined) return undefined;
    const stops = STOPS.map((place) => {
      const other = valueAt(parameter, place);
      if (channel === null) return hex(colourOf(other));
      return hex(colourOf(values.map((x, k) => (k === channel ? other : x)) as unknown as Rgb));
    });
    return `linear-gradient(90deg, ${stops.join(", ")})`;
  };

  return (
    <div class={split ? "field split" : "field"}>
      {/* biome-ignore lint/a11y/noStaticElementInteractions: a shortcut; the menu key is Delete on the slider */}
      <span class="label" title={`${parameter.hint} Double click: reset.`} onDblClick={reset}>
        {parameter.label}
      </span>
      <span class="aside">
        {aside}
        {parameter.isColour && <Swatch name={name} values={values} onChange={onChange} />}
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
              track={gradient(at)}
              parameter={parameter}
              value={values[at]!}
              onInput={(next) => set(at, next)}
              onReset={reset}
            />
          ))
        ) : (
          <Row
            name={name}
            track={gradient(null)}
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
  /** The slider's background. */
  track: string | undefined;
  parameter: Parameter;
  value: number;
  onInput: (value: number) => void;
  onReset: () => void;
}

/** Steps of a slider, and the places at which its track's colour is computed. */
const STEPS = 500;
const STOPS = [0, 0.2, 0.4, 0.6, 0.8, 1];

function Row({ name, channel, track, parameter, value, onInput, onReset }: RowProps) {
  return (
    <div class="row">
      <Slider
        class={channel ?? ""}
        track={track}
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
  values: Rgb;
  onChange: (value: Channels, kind: string) => void;
}

function Swatch({ name, values, onChange }: SwatchProps) {
  return (
    <input
      type="color"
      class="swatch"
      aria-label={`${name}: choose`}
      title="Choose the colour"
      value={hex(values)}
      onInput={(event) => onChange(joined(fromHex(event.currentTarget.value)), `${name} colour`)}
    />
  );
}
