/** The medium of a coat by what people see of it, or by its physics; see `core.appearance` of Python. */

import type { Channels } from "../core/api";
import { medium } from "../printed/formulas";
import { each, joined, type Rgb, rgb } from "./channels";

/** A medium by its appearance, at thickness 1. */
export interface Look {
  /** What passes a clear coat twice, at normal incidence. */
  color: Channels;
  /** How opaque the pigment is, in [0, 1], and its colour. */
  body: Channels;
  bodyColor: Channels;
}

/** A medium by its physics, at thickness 1. */
export interface Physics {
  albedo: Channels;
  sigmaT: Channels;
}

/** A medium as it was given, and its Henyey-Greenstein asymmetry. */
export type Medium = (Look | Physics) & { g: Channels };

/** Albedo and optical depth of a medium. */
export function physicsOf(coat: Medium): Physics {
  if ("sigmaT" in coat) return { albedo: coat.albedo, sigmaT: coat.sigmaT };
  const out = new Float64Array(6);
  const [color, body, bodyColor, g] = [coat.color, coat.body, coat.bodyColor, coat.g].map(rgb);
  for (let k = 0; k < 3; k++) medium(color![k], body![k], bodyColor![k], g![k], out, 2 * k);
  return { albedo: joined(each((k) => out[2 * k])), sigmaT: joined(each((k) => out[2 * k + 1])) };
}

/** The appearance of a medium: of a clear dye if nothing scatters, otherwise of a paint. */
export function lookOf(coat: Medium): Look {
  if ("color" in coat) return { color: coat.color, body: coat.body, bodyColor: coat.bodyColor };
  const [albedo, depth, g] = [rgb(coat.albedo), rgb(coat.sigmaT), rgb(coat.g)];
  if (Math.max(...albedo) === 0)
    return { color: joined(each((k) => Math.exp(-2 * depth[k]))), body: 0, bodyColor: 0.8 };
  const pigment = (k: number) => depth[k] * (1 - albedo[k] * g[k]);
  return {
    color: 1,
    body: joined(each((k) => pigment(k) / (4 / 3 + pigment(k)))),
    bodyColor: joined(each((k) => deepReflectance(albedo[k], g[k]))),
  };
}

/** Dye and pigment of one colour: the dye is the paler the more the pigment hides. */
function dyed(colour: Channels, body: Channels): Look {
  const [c, hidden] = [rgb(colour), rgb(body)];
  const color = each((k) => Number((c[k] ** (1 - hidden[k])).toFixed(4)));
  return { color: joined(color), body, bodyColor: colour };
}

/** A coat of one colour, whose opacity stays. */
export function withColour<Coat extends Medium>(coat: Coat, colour: Channels): Coat {
  return withLook(coat, dyed(colour, lookOf(coat).body));
}

/** The colour of which dye and pigment are, or a dye alone that is not clear; otherwise null. */
function oneColour({ color, body, bodyColor }: Look): Channels | null {
  const dye = rgb(dyed(bodyColor, body).color);
  if (rgb(color).every((x, k) => Math.abs(x - dye[k]) < 0.002)) return bodyColor;
  return Math.max(...rgb(body)) === 0 && color !== 1 ? color : null;
}

/** The colour of a look: where dye and pigment differ, that of the one that is seen more. */
export function colourOf(look: Look): Channels {
  return oneColour(look) ?? (Math.max(...rgb(look.body)) > 0.5 ? look.bodyColor : look.color);
}

/** A coat of another opacity; its colour stays if it has one. */
export function withOpacity<Coat extends Medium>(coat: Coat, body: Channels): Coat {
  const look = lookOf(coat);
  const colour = oneColour(look);
  return withLook(coat, colour === null ? { ...look, body } : dyed(colour, body));
}

function withLook<Coat extends Medium>(coat: Coat, look: Look): Coat {
  const { albedo, sigmaT, ...others } = coat as Coat & Physics;
  return { ...others, ...look } as unknown as Coat;
}

/** How much of what lies below a medium of a thickness hides, in each channel. */
export function hiddenBy(coat: Medium, thickness: number): Rgb {
  const body = rgb(lookOf(coat).body);
  return each((k) => (thickness * body[k]) / (1 + (thickness - 1) * body[k] + 1e-9));
}

/** About the colour of a medium of a thickness over a reflectance, white if left out. */
export function colourOver(coat: Medium, thickness: number, below: Rgb = [1, 1, 1]): Rgb {
  const { color, bodyColor } = lookOf(coat);
  const [clear, hidden, pigment] = [rgb(color), hiddenBy(coat, thickness), rgb(bodyColor)];
  return each((k) => clear[k] ** thickness * ((1 - hidden[k]) * below[k] + hidden[k] * pigment[k]));
}

/** Reflectance of an infinitely deep medium (van de Hulst 1980). */
function deepReflectance(albedo: number, g: number): number {
  const s = Math.sqrt((1 - albedo) / (1 - albedo * g));
  return ((1 - s) * (1 - 0.139 * s)) / (1 + 1.17 * s);
}
