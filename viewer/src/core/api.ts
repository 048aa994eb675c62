/**
 * The values of the numeric core.
 *
 * Directions are unit vectors in the local frame, the normal along z and the tangent along x, three
 * numbers each. A parameter is one number for all colour channels or three. Codes are those of Urushi's networks,
 * one of `latentSize` numbers for every channel, row by row.
 */

import type { Vector } from "../printed/formulas";
import type { FTable, Widths } from "./f_table";

/** One number for all channels, or one for each of red, green and blue. */
export type Channels = number | readonly [number, number, number];

/** One coat: its interface, and the medium below it. */
export interface Coat {
  /** GGX width of the interface, in [0.01, 1]; along the tangent if there is another across. */
  alpha: Channels;
  /** GGX width across the tangent, if it differs. */
  alphaV?: Channels;
  /** Index relative to the medium above, in [0.5, 3]; at 1 there is no interface. */
  eta: Channels;
  /** Single-scattering albedo of the medium, in [0, 1]. */
  albedo: Channels;
  /** Optical depth of the medium, at least 0. */
  sigmaT: Channels;
  /** Henyey-Greenstein asymmetry of the medium, in (-1, 1). */
  g: Channels;
}

/** What lies under all coats, its index relative to them: a surface, or codes of a material. */
export type Bottom =
  | { kind: "conductor"; alpha: Channels; alphaV?: Channels; r0: Channels }
  | { kind: "conductor"; alpha: Channels; alphaV?: Channels; eta: Channels; k: Channels }
  | { kind: "dielectric"; alpha: Channels; alphaV?: Channels; eta: Channels }
  | { kind: "diffuse"; reflectance: Channels }
  | {
      kind: "codes";
      latents: Float32Array;
      /** Of the networks; 1 if left out. */
      widths?: Widths;
    };

/** A bottom and its coats, the topmost first. */
export interface Stack {
  bottom: Bottom;
  coats: readonly Coat[];
  /** Whether light that the topmost surface, a coat's or a metal's of one width, loses is given back. */
  energyCompensation?: boolean;
}

/** One material. */
export interface Material {
  /** Codes (3, latentSize): coats lie over them, directions are drawn by them. */
  latents: Float32Array;
  /** By which f is evaluated. */
  table: FTable;
}

/** Sizes of a table of directions. */
export interface DirectionSizes {
  /** Number of azimuths, in a quadrant from the tangent to the bitangent; 1 if it is isotropic. */
  azimuths: number;
  /** Number of cosines of the outgoing direction. */
  cosines: number;
  /** Number of directions for each cosine. */
  samples: number;
}

/** The incident direction of a row of a table: cosines in the middles of cells, for each azimuth. */
export function rowDirection(row: number, { azimuths, cosines }: DirectionSizes): Vector {
  const z = ((row % cosines) + 0.5) / cosines;
  const sine = Math.sqrt(1 - z * z);
  const azimuth = (0.5 * Math.PI * Math.floor(row / cosines)) / Math.max(azimuths - 1, 1);
  return { x: sine * Math.cos(azimuth), y: sine * Math.sin(azimuth), z };
}
