/**
 * Proposals, from which directions are drawn: mixtures of GGX reflection lobes, mirrored above the
 * horizon, and a cosine lobe; see Python's `nets.proposal`.
 */

import {
  LOBE,
  PROPOSAL,
  proposalWeights,
  reflectionPdf,
  type Vector,
  visibleNormal,
} from "../printed/formulas";
import type { Widths } from "./f_table";
import { passed } from "./lobe";

/** Weights (K + 1), the last the cosine lobe's, and GGX widths (K), also those across the tangent. */
export interface Mixture {
  readonly weights: Float64Array;
  readonly alphas: Float64Array;
  readonly alphasV: Float64Array;
}

/** The parameters of proposals: a linear map from a code without its lobe, and overlaps of lobes. */
export interface ProposalWeights {
  /** (numbers of a code, `TERMS`) */
  readonly weight: Float64Array;
  readonly bias: Float64Array;
  readonly overlap: Float64Array;
}

/** The proposal of a code, which begins with `lobe` numbers, for directions wi. */
export function proposalOf(
  { weight, bias, overlap }: ProposalWeights,
  lobe: number,
  code: Float32Array,
): (wi: Vector) => Mixture {
  const rest = code.subarray(lobe);
  const terms = bias.map((start, term) =>
    rest.reduce((sum, number, k) => sum + number * weight[k * PROPOSAL.TERMS + term], start),
  );
  const across = LOBE.NUMBERS[1].length;
  const widths: Widths = lobe === across ? 1 : 2;
  const numbers = Float64Array.of(...code.subarray(0, across), code[widths === 1 ? 0 : across]);
  const most = widths === 1 ? 0 : PROPOSAL.LARGEST_STRETCH;
  const stretch = Math.exp(Math.min(Math.max(code[code.length - 1], -most), most));
  const alphas = Float64Array.of(code[0], ...PROPOSAL.ALPHAS.map((alpha) => alpha / stretch));
  const alphasV = Float64Array.of(
    numbers[across],
    ...PROPOSAL.ALPHAS.map((alpha) => alpha * stretch),
  );
  return (wi) => {
    const weights = new Float64Array(alphas.length + 1);
    proposalWeights(terms, overlap, numbers, wi.z, passed(code, widths, wi), weights, 0);
    return { weights, alphas, alphasV };
  };
}

/** The density [1/sr] of `sampleMixture` at wo; 0 below the horizon. */
export function mixtureDensity(
  { weights, alphas, alphasV }: Mixture,
  wi: Vector,
  wo: Vector,
): number {
  if (!(wi.z > 0 && wo.z > 0)) return 0;
  let density = (weights[alphas.length] * wo.z) / Math.PI;
  for (let k = 0; k < alphas.length; k++) {
    const lobe = reflectionPdf(alphas[k], alphasV[k], wi.x, wi.y, wi.z, wo.x, wo.y, wo.z);
    density += weights[k] * lobe;
  }
  return density;
}

/** A direction drawn by three uniform numbers in [0, 1): the lobe by the first. */
export function sampleMixture(
  { weights, alphas, alphasV }: Mixture,
  wi: Vector,
  u0: number,
  u1: number,
  u2: number,
): Vector {
  let edge = weights[0];
  let chosen = 0;
  for (let k = 1; k < alphas.length; k++) {
    if (u0 >= edge) chosen = k;
    edge += weights[k];
  }
  if (u0 >= edge) {
    const [radius, phi] = [Math.sqrt(u1), 2 * Math.PI * u2];
    return { x: radius * Math.cos(phi), y: radius * Math.sin(phi), z: Math.sqrt(1 - u1) };
  }
  // Mirrored by a visible facet, and then up (Dupuy and Benyoub 2023)
  const { x, y, z } = visibleNormal(alphas[chosen], alphasV[chosen], wi.x, wi.y, wi.z, u1, u2);
  const twice = (2 * (wi.x * x + wi.y * y + wi.z * z)) / Math.max(x * x + y * y + z * z, 1e-18);
  return { x: twice * x - wi.x, y: twice * y - wi.y, z: Math.abs(twice * z - wi.z) };
}
