/** Evaluation of materials: f, the proposal, albedo, and tables of directions. */

import type { DirectionSizes, Material } from "./api";
import type { Basis } from "./basis";
import { CHANNELS, rows } from "./channels";
import { tableValues } from "./f_table";
import { Pairs, type Widths } from "./features";
import { QUADRATURE } from "./formulas";
import { lobeValue, passedBothWays } from "./lobe";
import { mixtureDensity, type ProposalWeights, proposalOf, sampleMixture } from "./mixture";
import { directionRule } from "./quadrature";
import { type Point, sequencePoint } from "./sequence";
import type { Architecture } from "./weights";

/** Sizes of the rules for albedos of one width and of two. */
const { POLAR_NODES, AZIMUTH_NODES, MIN_TANGENT } = QUADRATURE;
const sizes = (widths: Widths) => [POLAR_NODES, widths * AZIMUTH_NODES, 1e-3, MIN_TANGENT] as const;

export class Evaluation {
  /** Numbers of one channel's code. */
  readonly latentSize: number;
  /** GGX widths of a surface: networks of two are for anisotropic materials. */
  readonly widths: Widths;

  constructor(
    protected readonly arch: Architecture,
    protected readonly basis: Basis,
    private readonly proposal: ProposalWeights,
  ) {
    this.latentSize = arch.latent;
    this.widths = arch.widths;
  }

  /** The texels of the basis that shader code reads, four numbers each. */
  basisTexels(): Float32Array<ArrayBuffer> {
    return this.basis.texels();
  }

  /** The material of codes (3, L), with its table. */
  protected material(latents: Float32Array): Material {
    return { latents, table: this.basis.table(rows(latents, this.latentSize)) };
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
    cosines.forEach((cosine, row) => {
      if (!(cosine > 0)) return;
      const sine = Math.sqrt(Math.max(1 - cosine * cosine, 0));
      const wi = { x: sine, y: 0, z: cosine };
      const { wo, weights } = directionRule(wi, 1, sizes(this.widths));
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
   * The row of azimuth a and cosine c is for the incident direction of cosine (c + 1/2) / cosines
   * at the azimuth a / (azimuths - 1) of a quarter turn.
   *
   * @param shift in [0, 1)^3 of the sequence.
   * @returns (azimuths, cosines, samples, 8): the direction wo (3), f cos / pdf (3), pdf (1), and a zero.
   */
  table(
    material: Material,
    { azimuths, cosines, samples, shift }: DirectionSizes & { shift: Point },
  ): Float32Array {
    const result = new Float32Array(azimuths * cosines * samples * 8);
    const proposal = proposalOf(this.proposal, this.arch.lobe, this.meanCode(material));
    const uniform = Array.from({ length: samples }, (_, i) =>
      sequencePoint(i + 1, [0.5 + shift[0], 0.5 + shift[1], 0.5 + shift[2]]),
    );
    for (let row = 0; row < azimuths * cosines; row++) {
      const cosine = ((row % cosines) + 0.5) / cosines;
      const sine = Math.sqrt(1 - cosine * cosine);
      const azimuth = (0.5 * Math.PI * Math.floor(row / cosines)) / Math.max(azimuths - 1, 1);
      const wi = { x: sine * Math.cos(azimuth), y: sine * Math.sin(azimuth), z: cosine };
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
