/**
 * Conservation of energy: codes whose directional albedo is too high are scaled down.
 *
 * A code's lobe is exact, so only the rest is scaled, to what the lobe leaves of the largest albedo; see
 * Python's `material.energy`. A code is an array of all its numbers.
 */

import type { AtPairs, Basis } from "./basis";
import { Pairs } from "./features";
import { ALBEDO_RULE, ENERGY } from "./formulas";
import { lobeValues } from "./lobe";
import { directionRule } from "./quadrature";

const { MARGIN, LEAST_ALBEDO, LEAST_REST, TINY_FACTOR, TINY_FACTOR_ROUNDS } = ENERGY;

/** Largest directional albedo of a code. */
export const MOST_ALBEDO = 1 - MARGIN;

/** Directions at which albedos are measured. */
const { COSINES, AZIMUTHS } = ALBEDO_RULE;
const SIZES = { 1: { azimuths: 8, slopes: 32 }, 2: { azimuths: 8, slopes: 18 } };

export class EnergyLimit {
  /** Pairs of directions at which f must be known for albedos. */
  readonly pairs: Pairs;
  private readonly weights: readonly number[];
  /** The first pair of each direction wi, and the number of pairs. */
  private readonly bounds: readonly number[];
  private readonly cosines: readonly number[];
  private readonly nodes: AtPairs;

  /** @param gain place in a code of the logarithm of the rest's factor. */
  constructor(
    private readonly basis: Basis,
    private readonly gain: number,
  ) {
    const { widths } = basis;
    const directions = AZIMUTHS[widths].flatMap((azimuth) =>
      COSINES[widths].map((z) => {
        const sine = Math.sqrt(1 - z * z);
        return { x: sine * Math.cos(azimuth), y: sine * Math.sin(azimuth), z };
      }),
    );
    const rules = directions.map((wi) => directionRule(wi, widths, SIZES[widths]));
    this.cosines = directions.map(({ z }) => z);
    this.weights = rules.flatMap(({ weights }) => weights);
    const counts = rules.map(({ weights }) => weights.length);
    const before = (k: number) => counts.slice(0, k).reduce((sum, count) => sum + count, 0);
    this.bounds = [...counts.keys(), counts.length].map(before);
    const wi = rules.flatMap(({ weights }, k) => {
      const { x, y, z } = directions[k];
      return weights.flatMap(() => [x, y, z]);
    });
    const wo = rules.flatMap((rule) => rule.wo);
    this.pairs = Pairs.of(wi, wo, widths);
    this.nodes = basis.at(this.pairs);
  }

  /** The directional albedos of values f [1/sr] at the pairs. */
  albedos(f: Float64Array): Float64Array {
    return Float64Array.from(this.cosines, (_, k) => {
      let sum = 0;
      for (let i = this.bounds[k]; i < this.bounds[k + 1]; i++) sum += f[i] * this.weights[i];
      return sum;
    });
  }

  /**
   * Scale a code down in place so that its albedo is nowhere above the largest.
   *
   * A code far from the training data may have the greatest f that tables represent. It is scaled
   * and measured repeatedly. An interface of an index below one lies below another coat: it has no
   * limit.
   */
  limit(code: Float32Array): void {
    if (code[3] > 0 && code[4] < 1) return;
    const top = this.albedos(lobeValues(code, this.pairs));
    for (let round = 0; round <= TINY_FACTOR_ROUNDS; round++) {
      const rest = this.albedos(this.basis.values(code, this.nodes));
      const factors = rest.map((albedo, k) => {
        return Math.max(MOST_ALBEDO - top[k], LEAST_REST) / Math.max(albedo, LEAST_ALBEDO);
      });
      const factor = Math.min(...factors);
      if (factor < 1) code[this.gain] += Math.log(factor);
      if (factor >= TINY_FACTOR) return;
    }
  }
}
