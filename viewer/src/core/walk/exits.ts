/**
 * Paths out of a stack: one chain of refractions from wo down to every layer, drawn once per walk.
 *
 * A vertex in layer l connects to wo along a chain of directions that rise through the interfaces
 * l, ..., 0 without scattering. The walk can leave for the chain at any layer, so that several
 * techniques produce the same path. The power heuristic over all of them (Veach 1997) needs the
 * sums of squared density ratios that are kept here. Where an interface has the index 1, there is
 * none: the chain goes straight on, with the density and the ratios of the layer above. See Python's
 * `walk.exits`.
 */

import type { CoatOfChannel } from "../features";
import * as rough from "./interface";
import { flipped, negated, type Vector, vector } from "./vector";

/** The part of the chain above a vertex in layer l. */
export interface ExitPath {
  /** The propagation direction in the layer, z > 0. */
  readonly direction: Vector;
  /** Product over the chain of BTDF / density, times the direction's cosine; 0 if it failed. */
  readonly weight: number;
  /** Density [1/sr] of the direction, drawn from outside. */
  readonly pdf: number;
  /** One plus the squared density ratios of the techniques that connect above layer l. */
  readonly ratios: number;
}

const DOWN = vector(0, 0, -1);

/** The chain through all layers. */
export function exitPaths(
  coats: readonly CoatOfChannel[],
  wo: Vector,
  uniform: () => number,
): ExitPath[] {
  const paths: ExitPath[] = [];
  let outside = wo;
  let weight = 1;
  let ratios = 1;
  for (let index = 0; index < coats.length; index++) {
    const { alpha, eta } = coats[index];
    const drawn = rough.sampleTransmission(outside, alpha, eta, uniform(), uniform());
    // A failed sample gets a vertical direction, so that no cosine is zero.
    const inside = drawn.weight > 0 ? drawn.direction : DOWN;
    let pdf = eta === 1 ? Infinity : rough.transmission(outside, inside, alpha, eta).pdf;
    if (index > 0) {
      const above = paths[index - 1];
      weight *= Math.exp(-coats[index - 1].sigmaT / above.direction.z);
      const risen = rough.scatter(flipped(inside), flipped(above.direction), alpha, 1 / eta);
      const ratio = risen.pdf / above.pdf;
      ratios = 1 + (above.pdf > 0 ? ratio * ratio * above.ratios : 0);
      if (eta === 1) ({ pdf, ratios } = above);
    }
    // Light that leaves has the factors of light that enters divided by eta^2, because a cone of
    // light widens.
    weight *= drawn.weight / (eta * eta);
    outside = negated(inside);
    paths.push({ direction: outside, weight, pdf, ratios });
  }
  return paths;
}

/**
 * Weight of the connection at a vertex whose own sampling has the density `pdf`.
 *
 * @param below squared ratios of the techniques that connect at an earlier vertex, below this one.
 */
export function connectionWeight(path: ExitPath, pdf: number, below = 0): number {
  const ratio = pdf / path.pdf;
  return path.pdf > 0 ? 1 / (1 + ratio * ratio * path.ratios + below) : 0;
}
