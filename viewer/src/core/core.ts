/** The core: networks and energy limit behind the interface of `api.ts`. */

import { addAlbedos } from "./albedo_rule";
import type { Bottom, Coat, Core, Material, Stack, TableOptions } from "./api";
import { blended, PRESENT, presence } from "./blend";
import { Decoder, emptyRest, type PreparedCode, type Responses } from "./decoder";
import { Encoder } from "./encoder";
import { EnergyLimit, MARGIN } from "./energy";
import { Pairs } from "./features";
import { Layerer } from "./layerer";
import { lobeValue, NO_LOBE } from "./lobe";
import { activationOf } from "./mlp";
import { sequenceSteps } from "./probe_pairs";
import { halfVectorRule } from "./quadrature";
import { mixtureDensity, Sampler, sampleMixture } from "./sampler";
import { CHANNELS, coatOfChannel, lobeOfSurface, ofChannel, type Surface } from "./surfaces";
import { LOBE_NUMBERS, readWeights, type Weights } from "./weights";

/** The largest number below one of single precision, for uniform numbers. */
const BELOW_ONE = 1 - 2 ** -24;

/** Codes (1, L) of one channel. */
interface ChannelCodes {
  readonly code: Float32Array;
  readonly anchor: Float32Array;
}

/**
 * Read the networks' weights.
 *
 * @throws FileError if the file is damaged, or of networks that this core does not know.
 */
export function loadCore(safetensors: ArrayBuffer): NetworkCore {
  return new NetworkCore(readWeights(safetensors));
}

export class NetworkCore implements Core {
  readonly latentSize: number;
  private readonly decoder: Decoder;
  private readonly encoder: Encoder;
  private readonly layerer: Layerer;
  private readonly sampler: Sampler;
  private readonly energy: EnergyLimit;
  private readonly nothing: Float32Array;
  /** The latest bottom, which stays the same while its coats are changed. */
  private latest: { readonly name: string; readonly material: Material } | undefined;

  constructor(weights: Weights) {
    const activation = activationOf(weights.arch.activation);
    this.latentSize = weights.arch.latent;
    this.decoder = new Decoder(weights, activation);
    this.encoder = new Encoder(weights, this.decoder, activation);
    this.layerer = new Layerer(weights, activation);
    this.sampler = new Sampler(weights, activation);
    const dark = new Float64Array(weights.arch.probes);
    this.nothing = this.encoder.encode(NO_LOBE, dark).slice(LOBE_NUMBERS);
    this.energy = new EnergyLimit(this.decoder, this.nothing);
  }

  encode(bottom: Bottom): Material {
    if (bottom.kind === "codes") {
      return { latents: this.checked(bottom.latents), anchors: this.checked(bottom.anchors) };
    }
    const name = JSON.stringify(bottom);
    if (this.latest?.name !== name) {
      this.latest = { name, material: this.encodeSurface(bottom) };
    }
    const { latents, anchors } = this.latest.material;
    return { latents: latents.slice(), anchors: anchors.slice() };
  }

  layer(stack: Stack): Material {
    let material = this.encode(stack.bottom);
    for (let k = stack.coats.length - 1; k >= 0; k--) {
      const latents = this.coated(material, stack.coats[k]);
      material = { latents, anchors: latents };
    }
    return material;
  }

  f(material: Material, wi: Float32Array, wo: Float32Array): Float32Array {
    const pairs = Pairs.of(wi, wo);
    const values = this.values(material, pairs, pairs.capacity);
    for (let i = 0; i < pairs.capacity; i++) {
      if (!(wi[3 * i + 2] > 0 && wo[3 * i + 2] > 0)) {
        values.fill(0, CHANNELS * i, CHANNELS * (i + 1));
      }
    }
    return Float32Array.from(values);
  }

  pdf(material: Material, wi: Float32Array, wo: Float32Array): Float32Array {
    const proposal = this.sampler.proposals(this.meanAnchor(material));
    const result = new Float32Array(wi.length / 3);
    let cosine = Number.NaN;
    let mixture = proposal(1);
    for (let i = 0; i < result.length; i++) {
      const at = 3 * i;
      if (wi[at + 2] !== cosine) {
        cosine = wi[at + 2];
        mixture = proposal(cosine);
      }
      const x = wi[at] + wo[at];
      const y = wi[at + 1] + wo[at + 1];
      result[i] = mixtureDensity(mixture, cosine, wo[at + 2], x * x + y * y);
    }
    return result;
  }

  albedo(material: Material, cosines: Float32Array): Float32Array {
    const result = new Float32Array(CHANNELS * cosines.length);
    cosines.forEach((cosine, row) => {
      if (!(cosine > 0)) {
        return;
      }
      const { wo, weights } = halfVectorRule(cosine);
      const sine = Math.sqrt(Math.max(1 - cosine * cosine, 0));
      const pairs = new Pairs(weights.length);
      weights.forEach((_, i) => {
        pairs.set(i, sine, 0, cosine, wo[3 * i], wo[3 * i + 1], wo[3 * i + 2]);
      });
      const values = this.values(material, pairs, weights.length);
      for (let channel = 0; channel < CHANNELS; channel++) {
        let sum = 0;
        weights.forEach((weight, i) => {
          sum += values[CHANNELS * i + channel] * wo[3 * i + 2] * weight;
        });
        result[CHANNELS * row + channel] = sum;
      }
    });
    return result;
  }

  table(material: Material, { cosines, samples, shift }: TableOptions): Float32Array {
    const result = new Float32Array(cosines * samples * 8);
    const proposal = this.sampler.proposals(this.meanAnchor(material));
    const uniform = shiftedSequence(samples, shift);
    const pairs = new Pairs(samples);
    const densities = new Float64Array(samples);
    const wo = new Float64Array(3);
    for (let row = 0; row < cosines; row++) {
      const cosine = (row + 0.5) / cosines;
      const sine = Math.sqrt(1 - cosine * cosine);
      const mixture = proposal(cosine);
      for (let i = 0; i < samples; i++) {
        sampleMixture(
          mixture,
          [sine, cosine],
          uniform[3 * i],
          uniform[3 * i + 1],
          uniform[3 * i + 2],
          wo,
        );
        pairs.set(i, sine, 0, cosine, wo[0], wo[1], wo[2]);
        densities[i] = mixtureDensity(mixture, cosine, wo[2], pairs.across[i]);
        result.set(wo, (row * samples + i) * 8);
      }
      const values = this.values(material, pairs, samples);
      for (let i = 0; i < samples; i++) {
        const at = (row * samples + i) * 8;
        const density = densities[i];
        const factor = density > 0 ? result[at + 2] / density : 0;
        for (let channel = 0; channel < CHANNELS; channel++) {
          result[at + 3 + channel] = values[CHANNELS * i + channel] * factor;
        }
        result[at + 6] = density;
      }
    }
    return result;
  }

  /** Codes (3, L) scaled down, each as a whole, so that they reflect at most all light. */
  limited(codes: Float32Array): Float32Array {
    const own = rows(this.checked(codes).slice(), this.latentSize);
    for (const code of own) {
      this.energy.limit(code, 1 - MARGIN);
    }
    return this.joined(own);
  }

  /** Make tables ahead that are otherwise made when a width is first needed; see `LobeAlbedo`. */
  prepareWidth(index: number): void {
    this.energy.lobeAlbedo.prepare(index);
  }

  private encodeSurface(surface: Surface): Material {
    const numbers = [0, 1, 2].map((channel) => surfaceNumbers(surface, channel));
    const codes: ChannelCodes[] = [];
    for (let channel = 0; channel < CHANNELS; channel++) {
      const own = firstSame(channel, (a, b) => sameNumbers(numbers[a], numbers[b]));
      codes.push(own < channel ? codes[own] : this.encodeChannel(surface, channel));
    }
    return {
      latents: this.joined(codes.map(({ code }) => code)),
      anchors: this.joined(codes.map(({ anchor }) => anchor)),
    };
  }

  /** The code of one channel of a described surface, and its anchor. */
  private encodeChannel(surface: Surface, channel: number): ChannelCodes {
    const lobe = lobeOfSurface(surface, channel);
    if (surface.kind === "diffuse") {
      return this.encodeDiffuse(lobe, ofChannel(surface.reflectance, channel));
    }
    // It is its lobe alone. The anchor is what the encoder makes of it.
    const anchor = new Float32Array(this.latentSize);
    anchor.set(lobe);
    anchor.set(this.nothing, LOBE_NUMBERS);
    const code = anchor.slice();
    emptyRest(code, LOBE_NUMBERS);
    return { code, anchor };
  }

  private encodeDiffuse(lobe: Float32Array, reflectance: number): ChannelCodes {
    const { energy, encoder } = this;
    const value = reflectance / Math.PI;
    const values = new Float64Array(encoder.pairs.capacity).fill(value);
    const anchor = encoder.encode(lobe, values);
    const { code, excess } = encoder.correct(anchor, values);
    const own = new Float64Array(energy.rule.cosines.length);
    addAlbedos(energy.rule, new Float64Array(energy.rule.weights.length).fill(value), own);
    const ceiling = energy.ceilingOf(own);
    // Anchors are never rendered. They are limited only where they would bring light into a coat.
    if (Math.max(...own) * excess > 1 - MARGIN) {
      energy.limit(anchor, ceiling);
    }
    energy.limit(code, ceiling);
    return { code, anchor };
  }

  /** Codes (3, L) of a bottom under a coat. */
  private coated(bottom: Material, coat: Coat): Float32Array {
    const anchors = rows(bottom.anchors, this.latentSize);
    const latents = rows(bottom.latents, this.latentSize);
    const coats = anchors.map((_, channel) => coatOfChannel(coat, channel));
    const isSame = (a: number, b: number) =>
      sameNumbers(anchors[a], anchors[b]) &&
      sameNumbers(latents[a], latents[b]) &&
      sameNumbers(Object.values(coats[a]), Object.values(coats[b]));
    const own = anchors.map((_, channel) => firstSame(channel, isSame));
    const kept = own.filter((channel, place) => channel === place);
    const layered = this.layerer.layer(
      kept.map((channel) => anchors[channel]),
      kept.map((channel) => coats[channel]),
    );
    const codes = layered.map((code, place) => {
      const channel = kept[place];
      this.energy.limitCoated(code, anchors[channel]);
      const share = presence(coats[channel]);
      return share < PRESENT ? blended(this.energy, latents[channel], code, share) : code;
    });
    return this.joined(own.map((channel) => codes[kept.indexOf(channel)]));
  }

  /** f (count, 3) of the first pairs. */
  private values(material: Material, pairs: Pairs, count: number): Float64Array {
    const codes = rows(material.latents, this.latentSize);
    const responses = this.decoder.respond(pairs, count);
    const result = new Float64Array(CHANNELS * count);
    for (let channel = 0; channel < CHANNELS; channel++) {
      const own = firstSame(channel, (a, b) => sameNumbers(codes[a], codes[b]));
      if (own < channel) {
        for (let i = 0; i < count; i++) {
          result[CHANNELS * i + channel] = result[CHANNELS * i + own];
        }
      } else {
        this.valuesOfChannel(codes[channel], pairs, responses, result, channel);
      }
    }
    return result;
  }

  private valuesOfChannel(
    code: Float32Array,
    pairs: Pairs,
    responses: Responses,
    result: Float64Array,
    channel: number,
  ): void {
    const { decoder } = this;
    const prepared: PreparedCode = decoder.prepare(code, LOBE_NUMBERS);
    const numbers = Float64Array.from(code);
    for (let i = 0, at = channel; at < result.length; i++, at += CHANNELS) {
      result[at] = lobeValue(numbers, 0, pairs, i) + decoder.rest(prepared, responses, i);
    }
  }

  /** The mean of the channels' anchors, whose proposal all share. */
  private meanAnchor(material: Material): Float32Array {
    const anchors = rows(material.anchors, this.latentSize);
    return Float32Array.from(
      { length: this.latentSize },
      (_, k) => anchors.reduce((sum, code) => sum + code[k], 0) / anchors.length,
    );
  }

  private joined(codes: readonly Float32Array[]): Float32Array {
    const result = new Float32Array(codes.length * this.latentSize);
    codes.forEach((code, row) => {
      result.set(code, row * this.latentSize);
    });
    return result;
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

/** Points of Roberts' R sequence (2018) in three dimensions, shifted: (count, 3). */
function shiftedSequence(count: number, shift: readonly [number, number, number]): Float64Array {
  const steps = sequenceSteps(3);
  const points = new Float64Array(3 * count);
  for (let i = 0; i < count; i++) {
    for (let k = 0; k < 3; k++) {
      const x = 0.5 + (i + 1) * (steps[k] ?? 0) + (shift[k] ?? 0);
      points[3 * i + k] = Math.min(x - Math.floor(x), BELOW_ONE);
    }
  }
  return points;
}

function rows(codes: Float32Array, size: number): Float32Array[] {
  return Array.from({ length: CHANNELS }, (_, row) => codes.subarray(row * size, (row + 1) * size));
}

/** The first channel that is the same as the given one. */
function firstSame(channel: number, isSame: (a: number, b: number) => boolean): number {
  for (let other = 0; other < channel; other++) {
    if (isSame(other, channel)) {
      return other;
    }
  }
  return channel;
}

function surfaceNumbers(surface: Surface, channel: number): number[] {
  const diffuse = surface.kind === "diffuse" ? [ofChannel(surface.reflectance, channel)] : [];
  return [...lobeOfSurface(surface, channel), ...diffuse];
}

function sameNumbers(a: ArrayLike<number>, b: ArrayLike<number>): boolean {
  for (let i = 0; i < a.length; i++) {
    if (a[i] !== b[i]) {
      return false;
    }
  }
  return a.length === b.length;
}
