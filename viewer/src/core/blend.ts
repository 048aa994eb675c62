/**
 * Coats that are hardly there: an index close to 1 and a thin medium leave the bottom as it is.
 *
 * The layerer, which gives the coat's interface the only lobe, cannot express this; its codes are
 * blended with those of the bottom. See Python's `material.layer` and `material.blend`.
 */

import { scaleRest } from "./decoder";
import type { EnergyLimit } from "./energy";
import type { CoatOfChannel } from "./features";
import { BLEND, fresnel, LAYER } from "./formulas";
import { reflectance } from "./lobe";

const { ABSENT_CHANGE, ABSENT_WIDTH, ABSENT_DEPTH } = LAYER;

/** The share of a coat in a layered code: 0 where nothing is there, up to 1. */
export function presence({ alpha, alphaV, eta, sigmaT }: CoatOfChannel): number {
  const change = (eta - 1) / (eta + 1) / ABSENT_CHANGE;
  const square = eta === 1 ? 0 : (alpha * alpha + alphaV * alphaV) / 2;
  const width = square / ABSENT_WIDTH ** 2;
  return 1 - Math.exp(-(change * change) - width * width - sigmaT / ABSENT_DEPTH);
}

/**
 * The code between two codes, along which the light changes evenly.
 *
 * Factors of the lobes are blended linearly, widths, indices and rests in proportion to their light.
 *
 * @param share of b, in [0, 1].
 */
export function blended(
  energy: EnergyLimit,
  a: Float32Array,
  b: Float32Array,
  share: number,
): Float32Array {
  const lightA = mean(energy.restAlbedos(a));
  const lightB = mean(energy.restAlbedos(b));
  const wanted = (1 - share) * lightA + share * lightB;
  const part = (share * lightB) / wanted;
  const exactA = exactReflectance(a);
  const exactB = exactReflectance(b);
  const ofWidth = inProportion(meanReflectance(a), meanReflectance(b), share);
  const ofIndex = inProportion(a[3] * exactA, b[3] * exactB, share);
  const shares = [ofWidth, share, share, share, ofIndex, ofIndex, ofWidth];
  const code = a.map((number, k) => {
    const own = k < energy.lobe ? shares[k] : part;
    return (1 - own) * number + own * b[k];
  });
  // Never more than the linear blend, so that no light is gained at grazing angles.
  const exact = Math.max(exactReflectance(code), 1e-30);
  const factor = ((1 - share) * a[3] * exactA + share * b[3] * exactB) / exact;
  code[3] = Math.min(code[3], factor);
  scaleRest(code, energy.lobe, wanted / mean(energy.restAlbedos(code)));
  return code;
}

/** The share of b in proportion to two sizes; `share` itself where both are zero. */
function inProportion(sizeA: number, sizeB: number, share: number): number {
  const total = (1 - share) * sizeA + share * sizeB;
  return total > 0 ? (share * sizeB) / total : share;
}

/** Mean of the exact Fresnel term over the cosines, for a factor of one. */
function exactReflectance(lobe: Float32Array): number {
  return mean(BLEND.COSINES.map((cosine) => fresnel(cosine, lobe[4], lobe[5])));
}

function meanReflectance(lobe: Float32Array): number {
  return mean(BLEND.COSINES.map((cosine) => reflectance(lobe, 0, cosine)));
}

function mean(numbers: ArrayLike<number>): number {
  let sum = 0;
  for (let i = 0; i < numbers.length; i++) {
    sum += numbers[i];
  }
  return sum / numbers.length;
}
