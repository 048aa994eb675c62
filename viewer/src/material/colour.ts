/** Colours on screen for linear values, and back. */

import { each, type Rgb } from "./channels";

/** sRGB's curve, of a linear value in [0, 1]. */
export function encoded(linear: number): number {
  const x = Math.min(Math.max(linear, 0), 1);
  return x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055;
}

/** The linear value of sRGB's. */
export function decoded(value: number): number {
  return value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4;
}

/** "#rrggbb" of linear values. */
export function hex(colour: Rgb): string {
  const digits = colour.map((x) =>
    Math.round(255 * encoded(x))
      .toString(16)
      .padStart(2, "0"),
  );
  return `#${digits.join("")}`;
}

/** Linear values, with three digits, of "#rrggbb". */
export function fromHex(text: string): Rgb {
  return each((k) => {
    const linear = decoded(Number.parseInt(text.slice(1 + 2 * k, 3 + 2 * k), 16) / 255);
    return Number(linear.toFixed(3));
  });
}
