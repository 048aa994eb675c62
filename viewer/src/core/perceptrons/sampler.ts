/** Proposals of two GGX widths by a network, until a basis replaces it. */

import { CHECKS, LOBE, SAMPLER, samplerFeatures2, type Vector } from "../formulas";
import { lobeFeatures } from "../lobe";
import type { Mixture, Proposer } from "../mixture";
import { type Activation, Mlp } from "../mlp";
import type { PerceptronWeights } from "./weights";

export class Sampler implements Proposer {
  private readonly network: Mlp;

  constructor(
    private readonly weights: PerceptronWeights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.sampler, activation);
  }

  /** The proposals of a code for directions wi, of which each is computed when it is asked for. */
  proposals(code: Float32Array): (wi: Vector) => Mixture {
    const { arch, lobes } = this.weights;
    const { rest, lobe, widths } = arch;
    const ofLobe = LOBE.LOBE_FEATURES[widths];
    const ofCode = ofLobe + rest;
    const inputs = new Float64Array(ofCode + 2 * widths);
    lobeFeatures(code, inputs, 0, widths);
    inputs.set(code.subarray(lobe), ofLobe);
    const count = 1 + lobes;
    return ({ x, y, z }) => {
      samplerFeatures2(x, y, z, inputs, ofCode);
      const output = this.network.evaluate(inputs, 1);
      const ofWidth = (own: number, start: number) => {
        // Between ln 1 and ln MIN_ALPHA by a logistic function
        const logs = output
          .subarray(start, start + lobes)
          .map((x) => 0.5 - 0.5 * Math.tanh(0.5 * x));
        const alphas = [own, ...logs.map((share) => Math.exp(Math.log(CHECKS.MIN_ALPHA) * share))];
        return Float64Array.from(alphas, (alpha) => Math.min(Math.max(alpha, CHECKS.MIN_ALPHA), 1));
      };
      const alphas = ofWidth(code[0], count + 1);
      const alphasV = ofWidth(code[6], count + 1 + lobes);
      return { weights: shares(output.subarray(0, count + 1)), alphas, alphasV };
    };
  }
}

function shares(logits: Float64Array): Float64Array {
  const peak = Math.max(...logits);
  const weights = logits.map((logit) => Math.exp(logit - peak));
  const factor = (1 - SAMPLER.MIN_COSINE_SHARE) / weights.reduce((a, b) => a + b, 0);
  return weights.map((weight, k) => {
    const least = k + 1 === weights.length ? SAMPLER.MIN_COSINE_SHARE : 0;
    return weight * factor + least;
  });
}
