/** Described surfaces and coats, split into channels. */

import type { Bottom, Channels, Coat } from "./api";
import type { Widths } from "./f_table";
import { noLobe } from "./lobe";

/** The single precision value of a parameter for one channel, as Python computes with. */
export function ofChannel(value: Channels, channel: number): number {
  const chosen = typeof value === "number" ? value : value[channel];
  // + 0: a walk that divides by -0 gets a negative distance
  return Math.fround(chosen ?? Number.NaN) + 0;
}

/** The parameters of one coat for one channel. */
export interface CoatOfChannel {
  /** GGX widths along and across the tangent; networks of one width read the first. */
  alpha: number;
  alphaV: number;
  eta: number;
  albedo: number;
  sigmaT: number;
  g: number;
}

/** The parameters of a coat for one channel. */
export function coatOfChannel(coat: Coat, channel: number): CoatOfChannel {
  return {
    alpha: ofChannel(coat.alpha, channel),
    alphaV: ofChannel(coat.alphaV ?? coat.alpha, channel),
    eta: ofChannel(coat.eta, channel),
    albedo: ofChannel(coat.albedo, channel),
    sigmaT: ofChannel(coat.sigmaT, channel),
    g: ofChannel(coat.g, channel),
  };
}

/** A surface that is described by parameters, not by codes. */
export type Surface = Exclude<Bottom, { kind: "codes" }>;

/** The numbers of a surface's lobe for one channel; a diffuse surface has none. */
export function lobeOfSurface(surface: Surface, channel: number, widths: Widths): Float32Array {
  const numbers = Float32Array.from(noLobe(widths));
  if (surface.kind === "diffuse") {
    return numbers;
  }
  numbers[0] = ofChannel(surface.alpha, channel);
  if (widths === 2) {
    numbers[6] = ofChannel(surface.alphaV ?? surface.alpha, channel);
  }
  if ("r0" in surface) {
    numbers[1] = ofChannel(surface.r0, channel);
    numbers[2] = 1;
    return numbers;
  }
  numbers[3] = 1;
  numbers[4] = ofChannel(surface.eta, channel);
  numbers[5] = surface.kind === "conductor" ? ofChannel(surface.k, channel) : 0;
  return numbers;
}
