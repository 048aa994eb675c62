/**
 * The layerer: from the code of a bottom and a coat to the code of the coated BRDF.
 *
 * Coats outside the training data are moved into it; see `within_training` of Python's
 * `material.layer`.
 */

import {
  CHECKS,
  coatFeatures,
  FEATURES,
  LAYER,
  LAYERER,
  LOBE,
  lobeFeatures,
} from "../printed/formulas";
import { reflectance, widthsOfLobe } from "./lobe";
import type { Network } from "./network";
import type { CoatOfChannel } from "./surfaces";
import type { Architecture } from "./weights";

/** The code of a bottom under a coat. */
export function layered(
  { rest, lobe, widths }: Architecture,
  network: Network,
  bottom: Float32Array,
  { alpha, alphaV, eta, albedo, sigmaT, g }: CoatOfChannel,
): Float32Array {
  const ofLobe = LOBE.LOBE_FEATURES[widths];
  const input = new Float64Array(rest + ofLobe + FEATURES.COAT_FEATURES[2]);
  const code = bottom.slice();
  // What is fainter is no rest: its other numbers are those of rounding errors.
  if (code[lobe] <= LAYERER.LEAST_GAIN) code.fill(0, lobe).fill(LAYERER.LEAST_GAIN, lobe, lobe + 1);
  input.set(code.subarray(lobe));
  // Networks of one width have the first features of those of two: the other ones are written over.
  const [a, b, c] = LOBE.COSINES.map((cosine) => reflectance(bottom, cosine));
  lobeFeatures(...widthsOfLobe(bottom, widths), a, b, c, input, rest);
  coatFeatures(alpha, alphaV, eta, albedo, sigmaT, g, input, rest + ofLobe);
  code.set([alpha, 0, 0, 1, eta, 0, ...(widths === 2 ? [alphaV] : [])]);
  network
    .evaluate(input.subarray(0, rest + ofLobe + FEATURES.COAT_FEATURES[widths]))
    .forEach((change, k) => {
      code[lobe + k] += change;
    });
  return code;
}

const [LEAST_G, MOST_G] = CHECKS.TRAINED_G;
const { DEEPEST } = LAYER;

/**
 * A coat with a similar medium, in or near the range of the training data.
 *
 * Media of equal absorption and equal scattering times 1 - g transport light alike (van de Hulst
 * 1980). So g is moved into its range, and in media that are too deep further towards 0. Depths that
 * remain above `DEEPEST` are cut. Coats of index 1, which have no interface, get the least width.
 */
export function withinTraining(given: CoatOfChannel): CoatOfChannel {
  const smooth = { alpha: CHECKS.MIN_ALPHA, alphaV: CHECKS.MIN_ALPHA };
  const coat = given.eta === 1 ? { ...given, ...smooth } : given;
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
