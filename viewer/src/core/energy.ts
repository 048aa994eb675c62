/**
 * Conservation of energy: codes whose directional albedo is too high are scaled down.
 *
 * A code's lobe is exact, so only the rest is scaled, to what the lobe leaves of the ceiling; see
 * Python's `material.energy`. A code is an array of all its numbers.
 */

import { type AlbedoRule, addAlbedos, albedoRule } from "./albedo_rule";
import { AnisotropicLobeAlbedo } from "./anisotropic_lobe_albedo";
import type { AtPairs, Basis } from "./basis";
import { ENERGY } from "./formulas";
import { LobeAlbedo, type LobeAlbedos } from "./lobe_albedo";

const { MARGIN, SLACK, TOLERANCE, GRAZING, LEAST_ALBEDO, LEAST_REST } = ENERGY;
const { TINY_FACTOR, TINY_FACTOR_ROUNDS } = ENERGY;

/** A ceiling at all angles, or one for each of the rule's cosines. */
export type Ceiling = number | Float64Array;

export class EnergyLimit {
  readonly rule: AlbedoRule;
  readonly lobeAlbedo: LobeAlbedos;
  private readonly nodes: AtPairs;

  /** @param lobe numbers of a code's lobe. */
  constructor(
    private readonly basis: Basis,
    private readonly lobe: number,
  ) {
    const { widths } = basis;
    this.rule = albedoRule(widths);
    this.lobeAlbedo =
      widths === 1 ? new LobeAlbedo(this.rule.cosines) : new AnisotropicLobeAlbedo(this.rule);
    this.nodes = basis.at(this.rule.pairs);
  }

  /** Scale a code down in place so that its albedo is nowhere above a ceiling. */
  limit(code: Float32Array, ceiling: Ceiling): void {
    const factor = this.factor(code, ceiling);
    if (factor < 1) scaleRest(code, this.lobe, factor);
  }

  /** Ceiling (D) of a code's albedos, from those of its source. */
  ceilingOf(own: Float64Array): Float64Array {
    const peak = greatest(own);
    const top = peak > 1 + TOLERANCE ? peak : 1 - MARGIN;
    return own.map((albedo, d) =>
      this.rule.cosines[d] < GRAZING ? top : Math.min(albedo + SLACK, top),
    );
  }

  /** Directional albedos (D) of what the code's lobe does not reflect. */
  private restAlbedos(code: Float32Array): Float64Array {
    const albedos = new Float64Array(this.rule.cosines.length);
    addAlbedos(this.rule, this.basis.values(code, this.nodes), albedos);
    return albedos;
  }

  /**
   * The factor in (0, 1] that brings a code below a ceiling.
   *
   * A code far from the training data may decode to the greatest f that the decoder represents.
   * Then the factor is found by scaling and measuring repeatedly.
   */
  private factor(code: Float32Array, ceiling: Ceiling): number {
    let factor = this.measuredFactor(code, ceiling);
    let latest = factor;
    for (let round = 0; round < TINY_FACTOR_ROUNDS && latest < TINY_FACTOR; round++) {
      const scaled = code.slice();
      scaleRest(scaled, this.lobe, factor);
      latest = this.measuredFactor(scaled, ceiling);
      factor *= latest;
    }
    return factor;
  }

  /** Whether a code is limited: an interface of an index below one lies below another coat. */
  private isLimited(code: ArrayLike<number>): boolean {
    return code[3] <= 0 || code[4] >= 1;
  }

  private measuredFactor(code: Float32Array, ceiling: Ceiling): number {
    if (!this.isLimited(code)) {
      return 1;
    }
    const rest = this.restAlbedos(code);
    const top = new Float64Array(rest.length);
    this.lobeAlbedo.add(code, 0, top);
    let excess = 0;
    for (let d = 0; d < rest.length; d++) {
      const permitted = typeof ceiling === "number" ? ceiling : ceiling[d];
      const allowed = Math.max(permitted - top[d], LEAST_REST);
      excess = Math.max(excess, Math.max(rest[d], LEAST_ALBEDO) / allowed);
    }
    return Math.min(1 / excess, 1);
  }
}

function greatest(numbers: Float64Array): number {
  return numbers.reduce((a, b) => Math.max(a, b), Number.NEGATIVE_INFINITY);
}

/** Multiply the rest of a code, whose gain is at a place, by a factor > 0. */
function scaleRest(code: Float32Array, gain: number, factor: number): void {
  code[gain] += Math.log(factor);
}
