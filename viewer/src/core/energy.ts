/**
 * Conservation of energy: codes whose directional albedo is too high are scaled down.
 *
 * A code's lobe is exact, so only the rest is scaled, to what the lobe leaves of the largest albedo; see
 * Python's `material.energy`. A code is an array of all its numbers.
 */

import { ALBEDO_RULE, ENERGY, type Vector } from "../printed/formulas";
import type { AtPairs, Basis } from "./basis";
import { Pairs } from "./f_table";
import { mirrored } from "./facets";
import { passedBothWays, reflectance, widthsOfLobe } from "./lobe";
import { directionRule } from "./quadrature";

const { MARGIN, LEAST_ALBEDO, LEAST_REST, NO_FACTOR, ROUNDS, ROUGH_GAIN } = ENERGY;

/** Largest directional albedo of a code. */
export const MOST_ALBEDO = 1 - MARGIN;

/** Directions at which albedos are measured, and sizes of their rules. */
const { COSINES, AZIMUTHS, NODES } = ALBEDO_RULE;

/** Numbers that choose facets: a lattice of even heights and azimuths of the golden ratio. */
const FACETS = Array.from({ length: ENERGY.FACETS }, (_, k) => ({
  u1: (k * 0.6180339887498949) % 1,
  u2: (k + 0.5) / ENERGY.FACETS,
}));

/** The directional albedo of a lobe: the mean over visible facets (Heitz and d'Eon 2014). */
function lobeAlbedo(lobe: Float32Array, [u, v]: readonly [number, number], wi: Vector): number {
  const sum = FACETS.reduce((sum, { u1, u2 }) => {
    const { cosine, unhidden } = mirrored(u, v, wi, u1, u2);
    return sum + reflectance(lobe, cosine) * unhidden;
  }, 0);
  return sum / FACETS.length;
}

export class EnergyLimit {
  private readonly directions: readonly Vector[];
  /** The weights of pairs, and the places of their directions wi. */
  private readonly weights: readonly number[];
  private readonly rows: readonly number[];
  private readonly nodes: AtPairs;

  /** @param gain place in a code of the logarithm of the rest's factor. */
  constructor(
    private readonly basis: Basis,
    private readonly gain: number,
  ) {
    const { widths } = basis;
    this.directions = AZIMUTHS[widths].flatMap((azimuth) =>
      COSINES[widths].map((z) => {
        const sine = Math.sqrt(1 - z * z);
        return { x: sine * Math.cos(azimuth), y: sine * Math.sin(azimuth), z };
      }),
    );
    const rules = this.directions.map((wi) => directionRule(wi, widths, NODES[widths]));
    this.weights = rules.flatMap(({ weights }) => weights);
    this.rows = rules.flatMap(({ weights }, row) => weights.map(() => row));
    const wi = this.rows.flatMap((row) => Object.values(this.directions[row]));
    const wo = rules.flatMap((rule) => rule.wo);
    this.nodes = basis.at(new Pairs(wi, wo, widths));
  }

  /** The directional albedos of a code without its lobe. */
  private albedos(code: Float32Array): Float64Array {
    const albedos = new Float64Array(this.directions.length);
    this.basis.values(code, this.nodes).forEach((f, i) => {
      albedos[this.rows[i]] += passedBothWays(code, this.nodes.pairs, i) * f * this.weights[i];
    });
    return albedos;
  }

  /**
   * Scale a code down in place so that its albedo is nowhere above the largest.
   *
   * A code far from the training data may have the greatest f that tables represent. It is scaled
   * and measured repeatedly.
   */
  limit(code: Float32Array): void {
    const { directions } = this;
    // Rough lobes, which take longer, are measured where the bound by smooth ones does not suffice.
    const bounds = directions.map(({ z }) => reflectance(code, z) + ROUGH_GAIN);
    let allowed: number[] | undefined;
    for (let round = 0; round <= ROUNDS; round++) {
      const rest = this.albedos(code);
      if (allowed === undefined) {
        if (rest.every((albedo, k) => albedo <= allowedBeside(bounds[k]))) return;
        const widths = widthsOfLobe(code, this.basis.widths);
        allowed = directions.map((wi) => allowedBeside(lobeAlbedo(code, widths, wi)));
      }
      const most = allowed;
      const factors = rest.map((albedo, k) => most[k] / Math.max(albedo, LEAST_ALBEDO));
      const factor = Math.min(...factors);
      if (factor < 1) code[this.gain] += Math.log(factor);
      if (factor >= NO_FACTOR) return;
    }
  }
}

/** Albedo that the rest may have beside a lobe's. */
function allowedBeside(albedo: number): number {
  return Math.max(MOST_ALBEDO - albedo, LEAST_REST);
}
