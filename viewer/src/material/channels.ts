/** Values of the three channels: one number for all, or three. */

import type { Channels } from "../core/api";

export const COLOURS = ["red", "green", "blue"] as const;

export type Rgb = readonly [number, number, number];

/** Three numbers, from one for all channels or three. */
export function rgb(value: Channels): Rgb {
  return typeof value === "number" ? [value, value, value] : value;
}

/** One number if all three agree, otherwise the three. */
export function joined(value: Rgb): Channels {
  return value[0] === value[1] && value[1] === value[2] ? value[0] : value;
}

/** Every channel of a value by a function, as one number where it is one. */
export function mapped(value: Channels, change: (x: number) => number): Channels {
  if (typeof value === "number") return change(value);
  const [red, green, blue] = rgb(value);
  return [change(red), change(green), change(blue)];
}

/** Quotient of each channel, as one number if all three agree. */
export function quotient(a: Channels, b: Channels): Channels {
  const [x, y] = [rgb(a), rgb(b)];
  return joined([x[0] / y[0], x[1] / y[1], x[2] / y[2]]);
}
