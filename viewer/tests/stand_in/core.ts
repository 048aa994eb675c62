/**
 * A core without networks, for tests of the page: GGX lobes over a Lambertian lobe.
 *
 * A code has five numbers: width and reflectance of the top, of what is under it, and the
 * reflectance of the Lambertian lobe.
 */

import type { Bottom, Core, Material, Stack, TableOptions } from "../../src/core/api";
import { rgb } from "../../src/material/material";

const SIZE = 5;

export function standIn(): Core {
  const core: Core = {
    latentSize: SIZE,
    encode: (bottom) => core.layer({ bottom, coats: [] }),
    layer,
    f: (material, wi, wo) => values(material, wi, wo),
    pdf: (material, wi, wo) =>
      Float32Array.from({ length: wi.length / 3 }, (_, at) =>
        density(material, row(wi, at), row(wo, at)),
      ),
    albedo(material, cosines) {
      const samples = 64;
      const result = new Float32Array(3 * cosines.length);
      cosines.forEach((cosine, at) => {
        for (let i = 0; i < samples; i++) {
          const [wo, f, pdf] = drawn(material, cosine, i, samples, [0.3, 0.7, 0.1]);
          for (let k = 0; k < 3; k++) result[3 * at + k]! += (f[k]! * wo[2]) / pdf / samples;
        }
      });
      return result;
    },
    table(material, { cosines, samples, shift }: TableOptions) {
      const table = new Float32Array(8 * cosines * samples);
      for (let at = 0; at < cosines; at++)
        for (let i = 0; i < samples; i++) {
          const [wo, f, pdf] = drawn(material, (at + 0.5) / cosines, i, samples, shift);
          const weight = f.map((x) => (x * wo[2]) / pdf);
          table.set([...wo, ...weight, pdf, 0], 8 * (at * samples + i));
        }
      return table;
    },
  };
  return core;
}

function layer(stack: Stack): Material {
  const codes = new Float32Array(3 * SIZE);
  for (let channel = 0; channel < 3; channel++) {
    const base = bottomOf(stack.bottom, channel);
    const top = stack.coats[0];
    const factor = { lobe: 1, matt: 0 };
    for (const coat of stack.coats) {
      const depth = rgb(coat.sigmaT)[channel]!;
      const albedo = rgb(coat.albedo)[channel]!;
      factor.matt += factor.lobe * albedo ** 3 * (1 - Math.exp(-depth));
      factor.lobe *= Math.exp(-2 * depth);
    }
    const eta = top ? rgb(top.eta)[channel]! : 1;
    codes.set(
      [
        top ? rgb(top.alpha)[channel]! : 0.5,
        ((eta - 1) / (eta + 1)) ** 2,
        base.alpha,
        base.r0 * factor.lobe,
        base.matt * factor.lobe + factor.matt,
      ],
      SIZE * channel,
    );
  }
  return { latents: codes, anchors: codes };
}

function bottomOf(bottom: Bottom, channel: number): { alpha: number; r0: number; matt: number } {
  switch (bottom.kind) {
    case "conductor": {
      const alpha = rgb(bottom.alpha)[channel]!;
      if ("r0" in bottom) return { alpha, r0: rgb(bottom.r0)[channel]!, matt: 0 };
      const [eta, k] = [rgb(bottom.eta)[channel]!, rgb(bottom.k)[channel]!];
      return { alpha, r0: ((eta - 1) ** 2 + k * k) / ((eta + 1) ** 2 + k * k), matt: 0 };
    }
    case "dielectric": {
      const eta = rgb(bottom.eta)[channel]!;
      const alpha = rgb(bottom.alpha)[channel]!;
      return { alpha, r0: ((eta - 1) / (eta + 1)) ** 2, matt: 0 };
    }
    case "diffuse":
      return { alpha: 1, r0: 0, matt: rgb(bottom.reflectance)[channel]! };
    case "codes":
      return { alpha: 0.3, r0: 0.5, matt: 0 };
  }
}

type Vector = [number, number, number];

function row(vectors: Float32Array, at: number): Vector {
  return [vectors[3 * at]!, vectors[3 * at + 1]!, vectors[3 * at + 2]!];
}

function values(material: Material, wi: Float32Array, wo: Float32Array): Float32Array {
  const result = new Float32Array(wi.length);
  for (let at = 0; at < wi.length / 3; at++)
    result.set(one(material, row(wi, at), row(wo, at)), 3 * at);
  return result;
}

function one(material: Material, wi: Vector, wo: Vector): number[] {
  const { cosHalf, cosDifference } = half(wi, wo);
  const schlick = (1 - cosDifference) ** 5;
  return [0, 1, 2].map((channel) => {
    const [alpha, r0, below, r1, matt] = material.latents.subarray(SIZE * channel);
    const top = r0! > 0 ? r0! + (1 - r0!) * schlick : 0;
    const under = r1! > 0 ? r1! + (1 - r1!) * schlick : 0;
    return (
      top * lobe(alpha!, cosHalf, wi, wo) +
      (1 - top) ** 2 * (under * lobe(below!, cosHalf, wi, wo) + matt! / Math.PI)
    );
  });
}

function half(wi: Vector, wo: Vector): { cosHalf: number; cosDifference: number } {
  const sum = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]];
  const length = Math.hypot(...sum);
  return { cosHalf: sum[2]! / length, cosDifference: Math.min(length / 2, 1) };
}

function distribution(alpha: number, cosHalf: number): number {
  const inner = cosHalf * cosHalf * (alpha * alpha - 1) + 1;
  return (alpha * alpha) / (Math.PI * inner * inner);
}

function lobe(alpha: number, cosHalf: number, wi: Vector, wo: Vector): number {
  const masking = (c: number) => c + Math.sqrt(alpha ** 2 + (1 - alpha ** 2) * c * c);
  return distribution(alpha, cosHalf) / (masking(wi[2]) * masking(wo[2]));
}

function density(material: Material, wi: Vector, wo: Vector): number {
  const { cosHalf, cosDifference } = half(wi, wo);
  const [alpha, , below] = material.latents;
  const facets = (x: number) => (distribution(x, cosHalf) * cosHalf) / (4 * cosDifference);
  return (facets(alpha!) + facets(below!) + Math.max(wo[2], 0) / Math.PI) / 3;
}

function drawn(
  material: Material,
  cosine: number,
  place: number,
  samples: number,
  shift: readonly [number, number, number],
): [Vector, number[], number] {
  const u = ((place + 0.5) / samples + shift[0]) % 1;
  const v = (place * 0.6180339887 + shift[1]) % 1;
  const which = Math.floor(((place * 0.7548776662 + shift[2]) % 1) * 3);
  const wi: Vector = [Math.sqrt(1 - cosine * cosine), 0, cosine];
  const phi = 2 * Math.PI * v;
  let wo: Vector;
  if (which === 2) {
    wo = [Math.sqrt(u) * Math.cos(phi), Math.sqrt(u) * Math.sin(phi), Math.sqrt(1 - u)];
  } else {
    const alpha = material.latents[2 * which]!;
    const cos = Math.sqrt((1 - u) / (1 + (alpha * alpha - 1) * u));
    const sin = Math.sqrt(Math.max(1 - cos * cos, 0));
    const h: Vector = [sin * Math.cos(phi), sin * Math.sin(phi), cos];
    const along = 2 * (h[0] * wi[0] + h[2] * wi[2]);
    wo = [along * h[0] - wi[0], along * h[1], along * h[2] - wi[2]];
  }
  if (wo[2] < 1e-3) return [[0, 0, 1], [0, 0, 0], 1];
  return [wo, one(material, wi, wo), density(material, wi, wo)];
}
