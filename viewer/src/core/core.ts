/** The core: networks and energy limit behind the interface of `api.ts`. */

import type { Bottom, Coat, Core, Material, Stack } from "./api";
import { CHANNELS, firstSame, joined, rows, sameNumbers } from "./channels";
import { Compensations } from "./compensation";
import { Decoder } from "./decoder";
import { Encoder } from "./encoder";
import { EnergyLimit } from "./energy";
import { Evaluation } from "./evaluation";
import { ENERGY } from "./formulas";
import { Layerer, withinTraining } from "./layerer";
import { noLobe } from "./lobe";
import { MeasuredEncoder } from "./measured_encoder";
import { activationOf } from "./mlp";
import { Refinement } from "./refinement";
import { Sampler } from "./sampler";
import { SurfaceEncoder } from "./surface_encoder";
import { coatOfChannel } from "./surfaces";
import { readWeights, type Weights } from "./weights";

/**
 * Read the networks' weights.
 *
 * @throws FileError if the file is damaged, or of networks that this core does not know.
 */
export function loadCore(safetensors: ArrayBuffer): NetworkCore {
  return new NetworkCore(readWeights(safetensors));
}

export class NetworkCore extends Evaluation implements Core {
  readonly fingerprint: string;
  private readonly surfaces: SurfaceEncoder;
  private readonly measured: MeasuredEncoder;
  private readonly layerer: Layerer;
  private readonly energy: EnergyLimit;
  private readonly compensations = new Compensations(this);

  constructor(weights: Weights) {
    const activation = activationOf(weights.arch.activation);
    const decoder = new Decoder(weights, activation);
    super(decoder, new Sampler(weights, activation));
    const encoder = new Encoder(weights, activation);
    const dark = new Float64Array(weights.arch.probes);
    const { lobe, widths } = weights.arch;
    const nothing = encoder.encode(noLobe(widths), dark).slice(lobe);
    this.fingerprint = weights.fingerprint;
    this.layerer = new Layerer(weights, activation);
    this.energy = new EnergyLimit(decoder);
    this.surfaces = new SurfaceEncoder(encoder, this.energy, nothing);
    const refinement = new Refinement(weights, activation, decoder, encoder, this.energy);
    this.measured = new MeasuredEncoder(encoder, this.energy, refinement, nothing);
  }

  /** Encode a bottom without coats. */
  encode(bottom: Bottom): Material {
    return bottom.kind === "codes"
      ? { latents: this.checked(bottom.latents), anchors: this.checked(bottom.anchors) }
      : this.surfaces.encode(bottom);
  }

  encodeMeasured(file: ArrayBuffer): Material {
    return this.measured.encode(file);
  }

  layer(stack: Stack): Material {
    let material = this.encode(stack.bottom);
    let below = material;
    for (const coat of [...stack.coats].reverse()) {
      below = material;
      material = this.coated(material, coat);
    }
    const [top] = stack.coats;
    if (!stack.energyCompensation || top === undefined) return material;
    return { ...material, compensation: this.compensations.of(top, below) };
  }

  /** Codes (3, L) scaled down, each as a whole, so that they reflect at most all light. */
  limited(codes: Float32Array): Float32Array {
    const own = rows(this.checked(codes).slice(), this.latentSize);
    for (const code of own) {
      this.energy.limit(code, 1 - ENERGY.MARGIN);
    }
    return joined(own);
  }

  /** Make tables ahead that are otherwise made when a width is first needed; see `LobeAlbedo`. */
  prepareWidth(index: number): void {
    this.energy.lobeAlbedo.prepare(index);
  }

  /** A bottom under a coat, which leaves it as it is without an interface and a medium. */
  private coated(bottom: Material, coat: Coat): Material {
    const anchors = rows(bottom.anchors, this.latentSize);
    const latents = rows(bottom.latents, this.latentSize);
    const coats = anchors.map((_, channel) => coatOfChannel(coat, channel));
    const isSame = (a: number, b: number) =>
      sameNumbers(anchors[a], anchors[b]) &&
      sameNumbers(Object.values(coats[a]), Object.values(coats[b]));
    const own = anchors.map((_, channel) => firstSame(channel, isSame));
    const kept = own.filter((channel, place) => channel === place);
    const layered = this.layerer.layer(
      kept.map((channel) => anchors[channel]),
      kept.map((channel) => withinTraining(coats[channel])),
    );
    for (const code of layered) {
      this.energy.limit(code, 1 - ENERGY.MARGIN);
    }
    const codes = own.map((channel) => layered[kept.indexOf(channel)]);
    const absent = coats.map(({ eta, sigmaT }) => eta === 1 && sigmaT === 0);
    const chosen = (below: Float32Array[]) =>
      joined(codes.map((code, channel) => (absent[channel] ? below[channel] : code)));
    return { latents: chosen(latents), anchors: chosen(anchors) };
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
