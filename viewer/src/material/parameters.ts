/** The parameters of coats and bottoms: names, ranges, and their places on a slider. */

import type { Channels } from "../core/api";

/** How a parameter is shown, and which values it takes. */
export interface Parameter {
  label: string;
  /** One sentence on what it does. */
  hint: string;
  low: number;
  high: number;
  /** Largest value on the slider; a larger one can be typed. */
  slide?: number;
  /** The slider's place is the value's root of this degree, from `low`. */
  power: number;
  /** Value after a double click. */
  fallback: Channels;
  /** Whether it is a colour, which a swatch shows. */
  isColour?: true;
}

const width: Parameter = {
  label: "Roughness α",
  hint: "GGX width of the surface: 0.01 is a polished mirror, 1 is matt.",
  low: 0.01,
  high: 1,
  power: 2,
  fallback: 0.1,
};

/** The width in words of people: no physical quantity. */
export const GLOSS = share(
  "Gloss",
  "How sharply the surface reflects: 1 is a polished mirror, 0 is matt.",
  0.7,
);

/** Gloss of a width, with three digits: the width's place on its slider, from the other end. */
export function glossOf(alpha: number): number {
  return Number((1 - placeOf(width, alpha)).toFixed(3));
}

/** The width of a gloss, with as few digits as give the gloss back. */
export function alphaOf(gloss: number): number {
  const exact = width.low + (width.high - width.low) * (1 - gloss) ** width.power;
  const digits = [3, 4, 5].find((count) => glossOf(Number(exact.toFixed(count))) === gloss);
  return Number(exact.toFixed(digits ?? 6));
}

/** The widths along and across the tangent, where they are two. */
export const WIDTHS = {
  alpha: {
    ...width,
    label: "Roughness αᵤ",
    hint: "GGX width along the tangent, the direction of brushing or turning.",
  },
  alphaV: {
    ...width,
    label: "Roughness αᵥ",
    hint: "GGX width across the tangent.",
  },
} satisfies Record<string, Parameter>;

/** The angle of the tangent. */
export const ANGLE: Parameter = {
  label: "Tangent angle",
  hint: "Angle by which the tangent of all layers is turned about the normal, in degrees.",
  low: -90,
  high: 90,
  power: 1,
  fallback: 0,
};

/** An angle [degrees] in [-180, 180). */
export function wrapped(angle: number): number {
  return ((((angle + 180) % 360) + 360) % 360) - 180;
}

/** A number in [0, 1]. */
function share(label: string, hint: string, fallback: number): Parameter {
  return { label, hint, low: 0, high: 1, power: 1, fallback };
}

function colour(label: string, hint: string, fallback: number): Parameter {
  return { ...share(label, hint, fallback), isColour: true };
}

/** The colour of a coat, of its dye and its pigment together. */
export const COLOUR = colour(
  "Colour",
  "Colour of the coat: of its dye where it is clear, of its pigment where it is opaque.",
  1,
);

export const COAT_PARAMETERS = {
  alpha: width,
  color: colour(
    "Dye",
    "Colour of a clear dye: what light keeps that passes the coat twice, at thickness 1.",
    1,
  ),
  body: share(
    "Opacity",
    "How opaque the pigment is, at thickness 1: 0 is clear, 1 is opaque paint.",
    0,
  ),
  bodyColor: colour("Pigment", "Colour of an opaque layer of the pigment.", 0.8),
  thickness: {
    label: "Thickness",
    hint: "Factor of the medium's depth.",
    low: 0,
    high: 100,
    slide: 4,
    power: 2,
    fallback: 1,
  },
  ior: {
    label: "Index n",
    hint: "Index of refraction: water 1.33, varnish 1.5. Between equal indices there is no surface.",
    low: 0.51,
    high: 3,
    power: 1,
    fallback: 1.5,
  },
  sigmaT: {
    label: "Depth σₜ",
    hint: "Optical depth of the medium: how often light is absorbed or scattered on its way.",
    low: 0,
    high: 1000,
    slide: 10,
    power: 3,
    fallback: 0,
  },
  albedo: share(
    "Scattering",
    "Single-scattering albedo of the medium: 0 only absorbs, 1 only scatters.",
    0,
  ),
  g: {
    label: "Direction g",
    hint: "Asymmetry of the scattering: above 0 forwards, below 0 backwards.",
    low: -0.99,
    high: 0.99,
    power: 1,
    fallback: 0,
  },
} satisfies Record<string, Parameter>;

export const BOTTOM_PARAMETERS = {
  alpha: { ...width, fallback: 0.2 },
  r0: colour("Reflectance", "Reflectance at normal incidence.", 0.9),
  eta: {
    label: "Index n",
    hint: "Real part of the index of refraction.",
    low: 0,
    high: 10,
    slide: 6,
    power: 2,
    fallback: 1.5,
  },
  ior: COAT_PARAMETERS.ior,
  k: {
    label: "Extinction k",
    hint: "Imaginary part of the index of refraction.",
    low: 0,
    high: 20,
    slide: 10,
    power: 1,
    fallback: 3,
  },
  reflectance: colour("Reflectance", "Reflectance of the matt surface.", 0.5),
} satisfies Record<string, Parameter>;

/** The nearest value that a parameter can take. */
export function clamped({ low, high }: Parameter, value: number): number {
  return Math.min(Math.max(value, low), high);
}

/** Number of steps of every slider. */
export const STEPS = 500;

/** Place of a value on the slider, in [0, 1]. */
export function placeOf({ low, high, slide = high, power }: Parameter, value: number): number {
  return Math.min(Math.max((value - low) / (slide - low), 0), 1) ** (1 / power);
}

/** Value at a place of the slider, with three digits. */
export function valueAt(parameter: Parameter, place: number): number {
  const { low, high, slide = high, power } = parameter;
  return clamped(parameter, rounded(low + (slide - low) * place ** power));
}

/** The step of the slider that is nearest to a value. */
export function stepOf(parameter: Parameter, value: number): number {
  return Math.round(placeOf(parameter, value) * STEPS);
}

/**
 * Value at a step of the slider, or at the nearest one beyond it of another value than the present:
 * where several steps have the same rounded value, the arrow keys would not get on.
 */
export function valueBeyond(parameter: Parameter, step: number, present: number): number {
  const way = Math.sign(step - stepOf(parameter, present));
  let at = step;
  while (way !== 0 && at > 0 && at < STEPS && valueAt(parameter, at / STEPS) === present) at += way;
  return valueAt(parameter, at / STEPS);
}

/** A number with at most three digits after the point, and at least two that count. */
export function rounded(value: number): number {
  const digits = Math.abs(value) >= 0.1 || value === 0 ? 3 : 4;
  return Number(value.toFixed(digits));
}
