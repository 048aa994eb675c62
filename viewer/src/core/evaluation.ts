/** The evaluation of materials: f, albedos, and directions by the proposal. */

import { QUADRATURE } from "../printed/formulas";
import { type DirectionSizes, type Material, rowDirection } from "./api";
import { CHANNELS, rows } from "./channels";
import { Pairs, tableValues, type Widths } from "./f_table";
import { hasEdges, lobeValue, passedBothWays } from "./lobe";
import { mixtureDensity, proposalOf, sampleMixture } from "./mixture";
import { directionRule } from "./quadrature";
import { type Point, sequencePoint } from "./sequence";
import type { Weights } from "./weights";

/** Sizes of the rules for albedos of one width and of two. */
const { POLAR_NODES, EDGE_NODES, AZIMUTH_NODES, MIN_TANGENT } = QUADRATURE;
const ruleOf = (widths: Widths, edges: boolean) =>
  [edges ? EDGE_NODES : POLAR_NODES, widths * AZIMUTH_NODES, 1e-3, MIN_TANGENT] as const;

/** Evaluates materials of networks. */
export class Evaluation {
  /** Numbers of one channel's code. */
  readonly latentSize: number;
  /** GGX widths of a surface: networks of two are for anisotropic materials. */
  readonly widths: Widths;

  constructor(protected readonly weights: Weights) {
    this.latentSize = weights.arch.latent;
    this.widths = weights.arch.widths;
  }

  /** The BRDF [1/sr], without cosine: (N, 3) for directions (N, 3). */
  f(material: Material, wi: Float32Array, wo: Float32Array): Float32Array {
    const pairs = new Pairs(wi, wo, this.widths);
    const values = this.values(material, pairs);
    for (let i = 0; i < pairs.count; i++) {
      if (!(wi[3 * i + 2] > 0 && wo[3 * i + 2] > 0)) {
        values.fill(0, CHANNELS * i, CHANNELS * (i + 1));
      }
    }
    return Float32Array.from(values);
  }

  /** Directional albedo: (N, 3) for N cosines of the incident direction, in the plane y = 0. */
  albedo(material: Material, cosines: Float32Array): Float32Array {
    const result = new Float32Array(CHANNELS * cosines.length);
    const rule = ruleOf(this.widths, rows(material.latents, this.latentSize).some(hasEdges));
    cosines.forEach((cosine, row) => {
      if (!(cosine > 0)) return;
      const sine = Math.sqrt(Math.max(1 - cosine * cosine, 0));
      const wi = { x: sine, y: 0, z: cosine };
      const { wo, weights } = directionRule(wi, 1, rule);
      const own = weights.flatMap(() => [sine, 0, cosine]);
      const pairs = new Pairs(own, wo, this.widths);
      const values = this.values(material, pairs);
      for (let channel = 0; channel < CHANNELS; channel++) {
        let sum = 0;
        weights.forEach((weight, i) => {
          sum += values[CHANNELS * i + channel] * weight;
        });
        result[CHANNELS * row + channel] = sum;
      }
    });
    return result;
  }

  /**
   * Directions by the proposal from one low-discrepancy sequence, the same for all rows.
   *
   * A row is for the incident direction of `rowDirection`.
   *
   * @param shift in [0, 1)^3 of the sequence.
   * @returns (azimuths, cosines, samples, 8): the direction wo (3), f cos / pdf (3), pdf (1), and a zero.
   */
  table(material: Material, { shift, ...sizes }: DirectionSizes & { shift: Point }): Float32Array {
    const { azimuths, cosines, samples } = sizes;
    const result = new Float32Array(azimuths * cosines * samples * 8);
    const { proposal: parameters, arch } = this.weights;
    const proposal = proposalOf(parameters, arch.lobe, this.meanCode(material));
    const uniform = Array.from({ length: samples }, (_, i) =>
      sequencePoint(i + 1, [0.5 + shift[0], 0.5 + shift[1], 0.5 + shift[2]]),
    );
    for (let row = 0; row < azimuths * cosines; row++) {
      const wi = rowDirection(row, sizes);
      const mixture = proposal(wi);
      const drawn = uniform.map((point) => sampleMixture(mixture, wi, ...point));
      const own = drawn.flatMap(() => [wi.x, wi.y, wi.z]);
      const pairs = new Pairs(
        own,
        drawn.flatMap(({ x, y, z }) => [x, y, z]),
        this.widths,
      );
      const values = this.values(material, pairs);
      drawn.forEach((wo, i) => {
        const density = mixtureDensity(mixture, wi, wo);
        const factor = density > 0 ? wo.z / density : 0;
        const weights = values.subarray(CHANNELS * i, CHANNELS * (i + 1)).map((f) => f * factor);
        result.set([wo.x, wo.y, wo.z, ...weights, density], (row * samples + i) * 8);
      });
    }
    return result;
  }

  /** f (pairs, 3). */
  private values({ table, latents }: Material, pairs: Pairs): Float64Array {
    const result = tableValues(table, pairs, CHANNELS);
    if (table.besideLobe)
      rows(latents, this.latentSize).forEach((code, channel) => {
        for (let i = 0; i < pairs.count; i++) {
          const at = CHANNELS * i + channel;
          result[at] = lobeValue(code, pairs, i) + passedBothWays(code, pairs, i) * result[at];
        }
      });
    return result;
  }

  /** The mean of the channels' codes, whose proposal all share. */
  private meanCode({ latents }: Material): Float32Array {
    const codes = rows(latents, this.latentSize);
    return Float32Array.from(
      { length: this.latentSize },
      (_, k) => codes.reduce((sum, code) => sum + code[k], 0) / codes.length,
    );
  }
}
