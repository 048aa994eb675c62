/** Coats outside the networks' training data; see `within_training` of Python's `material.layer`. */

import type { CoatOfChannel } from "./features";

/** Asymmetries in the training data. */
const [LEAST_G, MOST_G] = [-0.8, 0.9];

/** Optical depth to which deeper media are cut. */
const DEEPEST = 12;

/**
 * A coat with a similar medium, in or near the range of the training data.
 *
 * Media of equal absorption and equal scattering times 1 - g transport light alike (van de Hulst
 * 1980). So g is moved into its range, and in media that are too deep further towards 0. Depths that
 * remain above `DEEPEST` are cut.
 */
export function withinTraining(coat: CoatOfChannel): CoatOfChannel {
  let g = Math.min(Math.max(coat.g, LEAST_G), MOST_G);
  if (g === coat.g && coat.sigmaT <= DEEPEST) return coat;
  const absorption = coat.sigmaT * (1 - coat.albedo);
  const reduced = coat.sigmaT * coat.albedo * (1 - coat.g);
  if (absorption + reduced / (1 - g) > DEEPEST) {
    const least = 1 - reduced / Math.max(DEEPEST - absorption, 1e-6);
    g = Math.min(Math.max(least, Math.min(g, 0)), g);
  }
  const scattering = reduced / (1 - g);
  const depth = absorption + scattering;
  const albedo = depth > 0 ? scattering / depth : coat.albedo;
  return { ...coat, albedo, sigmaT: Math.min(depth, DEEPEST), g };
}
