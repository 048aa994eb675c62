/** The core: basis, networks and energy limit. */

import type { Bottom, Coat, Material, Stack } from "./api";
import { Basis } from "./basis";
import { CHANNELS, joined, perChannel, rows } from "./channels";
import { compensationOf, withLobe } from "./compensation";
import { Encoder } from "./encoder";
import { EnergyLimit } from "./energy";
import { Evaluation } from "./evaluation";
import { layered, withinTraining } from "./layerer";
import { Proposals } from "./mixture";
import type { Network } from "./network";
import { coatOfChannel } from "./surfaces";
import { type Architecture, readWeights, type Weights } from "./weights";

/**
 * Read the weights.
 *
 * @throws FileError if the file is damaged, or of networks that this core does not know.
 */
export function loadCore(safetensors: ArrayBuffer): NetworkCore {
  return new NetworkCore(readWeights(safetensors));
}

/** Urushi's basis and networks, and the energy limit. */
export class NetworkCore extends Evaluation {
  /** Identifies the networks: a saved material names those it belongs to. */
  readonly fingerprint: string;
  private readonly encoder: Encoder;
  private readonly arch: Architecture;
  private readonly layerer: Network;
  private readonly energy: EnergyLimit;

  constructor({ arch, basis: parameters, fingerprint, layerer, proposal }: Weights) {
    const basis = new Basis(parameters, arch.lobe);
    super(arch, basis, new Proposals(proposal, arch.lobe));
    this.fingerprint = fingerprint;
    [this.arch, this.layerer] = [arch, layerer];
    this.energy = new EnergyLimit(basis, arch.lobe);
    this.encoder = new Encoder(basis, this.energy);
  }

  /** The codes of a bottom without coats. */
  encode(bottom: Bottom): Float32Array {
    return bottom.kind === "codes" ? this.checked(bottom.latents) : this.encoder.encode(bottom);
  }

  /**
   * Encode a measured BRDF, a MERL table or an isotropic RGL material: its codes and its table.
   *
   * @throws FileError if the file is damaged, anisotropic or of another format.
   */
  encodeMeasured(file: ArrayBuffer): Material {
    return this.encoder.encodeMeasured(file);
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
    const [top] = stack.coats;
    if (!stack.energyCompensation || top === undefined) return material;
    return withLobe(material, compensationOf(top, this.material(below), this));
  }

  /** Codes (3, L) scaled down, each as a whole, so that they reflect at most all light. */
  limited(codes: Float32Array): Float32Array {
    const own = rows(this.checked(codes).slice(), this.latentSize);
    for (const code of own) {
      this.energy.limit(code);
    }
    return joined(own);
  }

  /** The codes of a bottom under a coat, which changes nothing without an interface and a medium. */
  private coated(bottom: Float32Array, coat: Coat): Float32Array {
    const below = rows(bottom, this.latentSize);
    const coats = below.map((_, channel) => coatOfChannel(coat, channel));
    return perChannel(
      (channel) => [...below[channel], ...Object.values(coats[channel])],
      (channel) => {
        const { eta, sigmaT } = coats[channel];
        if (eta === 1 && sigmaT === 0) return below[channel];
        const own = withinTraining(coats[channel]);
        const code = layered(this.arch, this.layerer, below[channel], own);
        this.energy.limit(code);
        return code;
      },
    );
  }

  private checked(codes: Float32Array): Float32Array {
    if (codes.length !== CHANNELS * this.latentSize || !codes.every(Number.isFinite)) {
      throw new RangeError(
        `a material has ${codes.length} numbers; these networks need three codes of ${this.latentSize}`,
      );
    }
    return codes;
  }
}
