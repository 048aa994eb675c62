/** The core: materials of stacks by basis, networks and energy limit. */

import { APPEARANCE } from "../printed/formulas";
import type { Bottom, Coat, Material, Stack } from "./api";
import { Basis } from "./basis";
import { CHANNELS, joined, perChannel, rows } from "./channels";
import { compensated, lostByCoat, lostByMetal } from "./compensation";
import { EnergyLimit, MOST_ALBEDO } from "./energy";
import { Evaluation } from "./evaluation";
import { layered, withinTraining } from "./layerer";
import { FileError } from "./safetensors";
import { coatOfChannel, lobeOfSurface, ofChannel } from "./surfaces";
import { readWeights, type Weights } from "./weights";

const { WI, WO } = APPEARANCE;

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

/** Urushi's basis and networks with the energy limit. */
export class NetworkCore extends Evaluation {
  /** Identifies the networks: a saved material names those it belongs to. */
  readonly fingerprint: string;
  private readonly basis: Basis;
  private readonly energy: EnergyLimit;

  constructor(weights: Weights) {
    super(weights);
    const { arch, basis, fingerprint } = weights;
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
}
