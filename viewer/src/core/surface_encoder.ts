/** Encoding of described surfaces without coats; see Python's `material.encode`. */

import { addAlbedos } from "./albedo_rule";
import type { Material } from "./api";
import { CHANNELS, firstSame, joined, sameNumbers } from "./channels";
import { emptyRest } from "./decoder";
import type { Encoder } from "./encoder";
import type { EnergyLimit } from "./energy";
import type { Widths } from "./features";
import { lobeOfSurface, ofChannel, type Surface } from "./surfaces";

/** The code of one channel, and its anchor. */
interface ChannelCodes {
  readonly code: Float32Array;
  readonly anchor: Float32Array;
}

export class SurfaceEncoder {
  /** The latest surface, which stays the same while its coats are changed. */
  private latest: { readonly name: string; readonly material: Material } | undefined;

  /** @param nothing the rest that the encoder makes of none. */
  constructor(
    private readonly encoder: Encoder,
    private readonly energy: EnergyLimit,
    private readonly nothing: Float32Array,
  ) {}

  /** The codes of a surface. */
  encode(surface: Surface): Material {
    const name = JSON.stringify(surface);
    if (this.latest?.name !== name) {
      this.latest = { name, material: this.encodeChannels(surface) };
    }
    const { latents, anchors } = this.latest.material;
    return { latents: latents.slice(), anchors: anchors.slice() };
  }

  private encodeChannels(surface: Surface): Material {
    const { widths } = this.encoder;
    const numbers = [0, 1, 2].map((channel) => surfaceNumbers(surface, channel, widths));
    const codes: ChannelCodes[] = [];
    for (let channel = 0; channel < CHANNELS; channel++) {
      const own = firstSame(channel, (a, b) => sameNumbers(numbers[a], numbers[b]));
      codes.push(own < channel ? codes[own] : this.encodeChannel(surface, channel));
    }
    return {
      latents: joined(codes.map(({ code }) => code)),
      anchors: joined(codes.map(({ anchor }) => anchor)),
    };
  }

  /** The code of one channel of a described surface, and its anchor. */
  private encodeChannel(surface: Surface, channel: number): ChannelCodes {
    const lobe = lobeOfSurface(surface, channel, this.encoder.widths);
    if (surface.kind === "diffuse") {
      return this.encodeDiffuse(lobe, ofChannel(surface.reflectance, channel));
    }
    // It is its lobe alone. The anchor is what the encoder makes of it.
    const anchor = joined([lobe, this.nothing]);
    const code = anchor.slice();
    emptyRest(code, lobe.length);
    return { code, anchor };
  }

  private encodeDiffuse(lobe: Float32Array, reflectance: number): ChannelCodes {
    const { energy, encoder } = this;
    const value = reflectance / Math.PI;
    const values = new Float64Array(encoder.pairs.capacity).fill(value);
    const anchor = encoder.encode(lobe, values);
    const nodes = new Float64Array(energy.rule.weights.length).fill(value);
    const code = anchor.slice();
    const own = new Float64Array(energy.rule.cosines.length);
    addAlbedos(energy.rule, nodes, own);
    energy.limit(code, energy.ceilingOf(own));
    return { code, anchor };
  }
}

function surfaceNumbers(surface: Surface, channel: number, widths: Widths): number[] {
  const diffuse = surface.kind === "diffuse" ? [ofChannel(surface.reflectance, channel)] : [];
  return [...lobeOfSurface(surface, channel, widths), ...diffuse];
}
