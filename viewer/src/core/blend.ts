/**
 * Coats that are hardly there: an index close to 1 and a thin medium leave the bottom as it is.
 *
 * The layerer, which gives the coat's interface the only lobe, cannot express this; its codes are
 * blended with those of the bottom. See Python's `material.layer` and `material.blend`.
 */

import { scaleRest } from "./decoder";
import type { EnergyLimit } from "./energy";
import type { CoatOfChannel } from "./features";
import { reflectance } from "./lobe";
import { LOBE_NUMBERS } from "./weights";

/** Values of (eta - 1) / (eta + 1) and of sigma_t at which 1 - 1/e of a coat is present. */
const ABSENT_CHANGE = 0.005;
const ABSENT_DEPTH = 0.01;

/** The share from which all of a coat is present. */
export const PRESENT = 0.999;

/** Cosines over which the reflectance of a lobe is averaged. */
const COSINES = [1.0, 0.8, 0.6, 0.4, 0.2] as const;

/** The share of a coat in a layered code: 0 where nothing is there, up to 1. */
export function presence({ eta, sigmaT }: CoatOfChannel): number {
  const change = (eta - 1) / (eta + 1) / ABSENT_CHANGE;
  return 1 - Math.exp(-(change * change) - sigmaT / ABSENT_DEPTH);
}

/**
 * The code between two codes, along which the light changes evenly.
 *
 * Factors of the lobes are blended linearly, widths and rests in proportion to their light.
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
  const shares = sharesOfLobe(a, b, share);
  const code = a.map((number, k) => {
    const own = k < LOBE_NUMBERS ? shares[k] : part;
    return (1 - own) * number + own * b[k];
  });
  scaleRest(code, LOBE_NUMBERS, wanted / mean(energy.restAlbedos(code)));
  return code;
}

/** Shares of b in the numbers of the lobe. */
function sharesOfLobe(a: Float32Array, b: Float32Array, share: number): number[] {
  const inProportion = (sizeA: number, sizeB: number): number => {
    const total = (1 - share) * sizeA + share * sizeB;
    return total > 0 ? (share * sizeB) / total : share;
  };
  const ofWidth = inProportion(meanReflectance(a), meanReflectance(b));
  const ofIndex = inProportion(a[3], b[3]);
  return [ofWidth, share, share, share, ofIndex, ofIndex];
}

function meanReflectance(lobe: Float32Array): number {
  return mean(COSINES.map((cosine) => reflectance(lobe, 0, cosine)));
}

function mean(numbers: ArrayLike<number>): number {
  let sum = 0;
  for (let i = 0; i < numbers.length; i++) {
    sum += numbers[i];
  }
  return sum / numbers.length;
}
