/** The core: codes of stacks by basis, networks and energy limit, and the evaluation of materials. */

import { APPEARANCE, QUADRATURE } from "../printed/formulas";
import {
  type Bottom,
  type Coat,
  type DirectionSizes,
  type Material,
  rowDirection,
  type Stack,
} from "./api";
import { Basis } from "./basis";
import { CHANNELS, joined, perChannel, rows } from "./channels";
import { compensated, lostByCoat, lostByMetal } from "./compensation";
import { EnergyLimit, MOST_ALBEDO } from "./energy";
import { tableValues } from "./f_table";
import { Pairs, type Widths } from "./features";
import { layered, withinTraining } from "./layerer";
import { hasEdges, lobeValue, passedBothWays } from "./lobe";
import { mixtureDensity, proposalOf, sampleMixture } from "./mixture";
import { directionRule } from "./quadrature";
import { FileError } from "./safetensors";
import { type Point, sequencePoint } from "./sequence";
import { coatOfChannel, lobeOfSurface, ofChannel } from "./surfaces";
import { readWeights, type Weights } from "./weights";

const { WI, WO } = APPEARANCE;

/** Sizes of the rules for albedos of one width and of two. */
const { POLAR_NODES, EDGE_NODES, AZIMUTH_NODES, MIN_TANGENT } = QUADRATURE;
const ruleOf = (widths: Widths, edges: boolean) =>
  [edges ? EDGE_NODES : POLAR_NODES, widths * AZIMUTH_NODES, 1e-3, MIN_TANGENT] as const;

/**
 * Read the weights.
 *
 * @throws FileError if the file is damaged, or of networks that this core does not know.
 */
export function loadCore(safetensors: ArrayBuffer): NetworkCore {
  return new NetworkCore(readWeights(safetensors));
}

/** What a material or a texture of codes depends on. */
export type Networks = Pick<NetworkCore, "latentSize" | "widths" | "fingerprint">;

/** Methods of the core that a worker has. */
export const METHODS = ["layer", "f", "albedo", "table", "basisTexels"] as const;

/** Urushi's basis and networks, and the energy limit. */
export class NetworkCore {
  /** Numbers of one channel's code. */
  readonly latentSize: number;
  /** GGX widths of a surface: networks of two are for anisotropic materials. */
  readonly widths: Widths;
  /** Identifies the networks: a saved material names those it belongs to. */
  readonly fingerprint: string;
  private readonly basis: Basis;
  private readonly energy: EnergyLimit;

  constructor(private readonly weights: Weights) {
    const { arch, basis, fingerprint } = weights;
    this.latentSize = arch.latent;
    this.widths = arch.widths;
    this.fingerprint = fingerprint;
    this.basis = new Basis(basis, arch.lobe);
    this.energy = new EnergyLimit(this.basis, arch.lobe);
  }

  /** The texels of the basis that shader code reads, four numbers each. */
  basisTexels(): Float32Array<ArrayBuffer> {
    return this.basis.texels();
  }

  /** The codes (3, L) of a bottom without coats. */
  encode(bottom: Bottom): Float32Array {
    if (bottom.kind === "codes") return this.checked(bottom.latents);
    // A surface is its lobe alone; a Lambertian one has none, and an even rest.
    const codes = [0, 1, 2].map((channel) => {
      const lobe = lobeOfSurface(bottom, channel, this.widths);
      const albedo = bottom.kind === "diffuse" ? ofChannel(bottom.reflectance, channel) : 0;
      return this.basis.withEven(lobe, Math.min(albedo, MOST_ALBEDO) / Math.PI);
    });
    return joined(codes);
  }

  /** Encode a stack: the bottom under all its coats, the energy limit included. */
  layer(stack: Stack): Material {
    let latents = this.encode(stack.bottom);
    let below = latents;
    for (const coat of [...stack.coats].reverse()) {
      below = latents;
      latents = this.coated(latents, coat);
    }
    const material = this.material(latents);
    if (!stack.energyCompensation || this.widths === 2) return material;
    const [top] = stack.coats;
    if (top !== undefined) {
      const under = this.material(below);
      const reflected = this.albedo(under, Float32Array.of(1));
      const seen = this.f(under, Float32Array.from(WI), Float32Array.from(WO));
      return compensated(material, lostByCoat(top, reflected, seen));
    }
    const { lobe: size } = this.weights.arch;
    const lobes = rows(latents, this.latentSize).map((code) => code.subarray(0, size));
    const lost = lostByMetal(lobes);
    // The codes, by which directions are drawn, have it evenly.
    const even = lobes.map((lobe, k) =>
      this.basis.withEven(lobe, (lost[k].colour * lost[k].loss.mean) / Math.PI),
    );
    return { ...compensated(material, lost), latents: joined(even) };
  }

  /** The codes of a bottom under a coat, which changes nothing without an interface and a medium. */
  private coated(bottom: Float32Array, coat: Coat): Float32Array {
    const { arch, layerer } = this.weights;
    const below = rows(bottom, this.latentSize);
    const coats = below.map((_, channel) => coatOfChannel(coat, channel));
    return perChannel(
      (channel) => [...below[channel], ...Object.values(coats[channel])],
      (channel) => {
        const { eta, sigmaT } = coats[channel];
        if (eta === 1 && sigmaT === 0) return below[channel];
        const own = withinTraining(coats[channel]);
        const code = layered(arch, layerer, below[channel], own);
        this.energy.limit(code);
        return code;
      },
    );
  }

  private checked(codes: Float32Array): Float32Array {
    const size = CHANNELS * this.latentSize;
    if (codes.length === size && codes.every(Number.isFinite)) return codes;
    throw new FileError(
      `The codes of the loaded material are damaged or of other networks (${codes.length} numbers, here ${size}); encode it again.`,
    );
  }

  /** The material of codes (3, L), with its table. */
  private material(latents: Float32Array): Material {
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
