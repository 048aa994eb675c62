/**
 * The layerer: from the code of a bottom and a coat to the code of the coated BRDF. It begins from the
 * first crossing if its weights were trained so, otherwise from the bottom.
 *
 * Coats outside the training data are moved into it; see `within_training` of Python's
 * `material.layer`.
 */

import type { Basis } from "./basis";
import type { CoatOfChannel } from "./features";
import { FirstCrossing } from "./first_crossing";
import { CHECKS, coatFeatures, coatFeatures2, FEATURES, LAYER, LAYERER, LOBE } from "./formulas";
import type { Architecture, Layer } from "./layers";
import { lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";

export class Layerer {
  private readonly network: Mlp;
  private readonly crossing: FirstCrossing | undefined;

  constructor(
    private readonly arch: Architecture,
    basis: Basis,
    layers: readonly Layer[],
    activation: Activation,
  ) {
    this.network = new Mlp(layers, activation);
    if (arch.crossing > 0) this.crossing = new FirstCrossing(basis, arch.crossing);
  }

  /** The codes of bottoms under coats, the same number of both. */
  layer(bottoms: readonly Float32Array[], coats: readonly CoatOfChannel[]): Float32Array[] {
    const { rest, lobe, widths } = this.arch;
    const { crossing } = this;
    const ofLobe = LOBE.LOBE_FEATURES[widths];
    const begun = rest + Number(crossing !== undefined);
    const width = begun + ofLobe + FEATURES.COAT_FEATURES[widths];
    const inputs = new Float64Array(bottoms.length * width);
    bottoms.forEach((bottom, row) => {
      const at = row * width;
      const own = bottom.slice(lobe);
      own[0] = Math.max(own[0], LAYERER.LEAST_GAIN);
      inputs.set(crossing ? crossing.code(own, bottom, coats[row]) : own, at);
      if (crossing) inputs[at + rest] = own[0];
      lobeFeatures(bottom, inputs, at + begun, widths);
      const { alpha, alphaV, eta, albedo, sigmaT, g } = coats[row];
      const place = at + begun + ofLobe;
      if (widths === 1) coatFeatures(alpha, eta, albedo, sigmaT, g, inputs, place);
      else coatFeatures2(alpha, alphaV, eta, albedo, sigmaT, g, inputs, place);
    });
    const changes = this.network.evaluate(inputs, bottoms.length);
    return bottoms.map((_, row) => {
      const across = widths === 2 ? [coats[row].alphaV] : [];
      const top = [coats[row].alpha, 0, 0, 1, coats[row].eta, 0, ...across];
      const numbers = Array.from(
        { length: rest },
        (_, k) => inputs[row * width + k] + changes[row * rest + k],
      );
      return Float32Array.of(...top, ...numbers);
    });
  }
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
