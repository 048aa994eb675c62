/** Values of the three channels: one number for all, or three. */

import type { Channels } from "../core/api";

export const COLOURS = ["red", "green", "blue"] as const;

export type Rgb = readonly [number, number, number];

/** Three numbers, from one for all channels or three. */
export function rgb(value: Channels): Rgb {
  return typeof value === "number" ? [value, value, value] : value;
}

/** Three numbers by a function of the channel. */
export function each(of: (channel: number) => number): Rgb {
  return [of(0), of(1), of(2)];
}

/** One number if all three agree, otherwise the three. */
export function joined(value: Rgb): Channels {
  return value[0] === value[1] && value[1] === value[2] ? value[0] : value;
}

/** Every channel of a value by a function, as one number where it is one. */
export function mapped(value: Channels, change: (x: number) => number): Channels {
  return typeof value === "number" ? change(value) : each((k) => change(value[k]));
}

/** Quotient of each channel, as one number if all three agree. */
export function quotient(a: Channels, b: Channels): Channels {
  const [x, y] = [rgb(a), rgb(b)];
  return joined(each((k) => x[k] / y[k]));
}
