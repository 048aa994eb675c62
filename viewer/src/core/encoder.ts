/** The encoder: from the values of a BRDF at the probe pairs to the code of its rest. */

import type { Decoder, Responses } from "./decoder";
import { Pairs, type Widths } from "./features";
import { CORRECTION, ENCODER, ERROR_METRICS, FIT } from "./formulas";
import { addRow, dampedStep } from "./least_squares";
import { lobeValues } from "./lobe";
import { type Activation, Mlp } from "./mlp";
import { probePairs } from "./probe_pairs";
import { DecoderSlopes } from "./slopes";
import type { Weights } from "./weights";

const { CORRECTION_STEPS, CORRECTION_DAMPING } = CORRECTION;
const { OFFSET } = ENCODER;
const { DARK_OFFSET } = ERROR_METRICS;

export class Encoder {
  /** The pairs at which values are needed. */
  readonly pairs: Pairs;
  private readonly network: Mlp;
  private readonly slopes: DecoderSlopes;
  /** Every second pair, which the correction fits, and the responses of the decoder to both. */
  private readonly fitted: Pairs;
  private readonly responses: Responses;
  private readonly fittedResponses: Responses;

  constructor(
    private readonly weights: Weights,
    private readonly decoder: Decoder,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.encoder, activation);
    this.slopes = new DecoderSlopes(decoder);
    this.pairs = probePairs(weights.arch.probes, weights.arch.widths);
    this.fitted = everySecond(this.pairs);
    this.responses = decoder.respond(this.pairs);
    this.fittedResponses = decoder.respond(this.fitted);
  }

  /** GGX widths of a surface. */
  get widths(): Widths {
    return this.weights.arch.widths;
  }

  /** The code of a lobe and values [1/sr] of the rest at the probe pairs. */
  encode(lobe: ArrayLike<number>, rest: ArrayLike<number>): Float32Array {
    const { arch, inputMean, inputScale } = this.weights;
    const inputs = Float64Array.from(
      { length: arch.probes },
      (_, i) => (Math.log(Math.max(rest[i], 0) + OFFSET) - inputMean[i]) / inputScale[i],
    );
    const code = new Float64Array(arch.latent);
    code.set(lobe);
    code.set(this.network.evaluate(inputs, 1).subarray(0, arch.rest), this.weights.arch.lobe);
    return Float32Array.from(code);
  }

  /**
   * Correct a code by damped steps of Gauss and Newton towards values f at the probe pairs.
   *
   * See Python's `material.fit.correct_codes`. The result is the last code that is better than the
   * given one at all pairs, or that one.
   */
  correct(code: Float32Array, f: ArrayLike<number>): Float32Array {
    const top = lobeValues(code, this.pairs);
    const logs = Float64Array.from(f, (value) => Math.log(value + DARK_OFFSET));
    const least = totalLoss(this.errors(code, top, logs));
    const tried: Float32Array[] = [];
    let current = code;
    for (let step = 0; step < CORRECTION_STEPS; step++) {
      current = this.corrected(current, top, logs);
      tried.unshift(current);
    }
    const better = tried.find((candidate) => totalLoss(this.errors(candidate, top, logs)) < least);
    return better ?? code.slice();
  }

  /** Errors of ln(f + offset) of a code at all probe pairs. */
  private errors(code: Float32Array, top: Float64Array, logs: Float64Array): Float64Array {
    const { decoder, responses } = this;
    const rest = decoder.rest(decoder.prepare(code, this.weights.arch.lobe), responses);
    return logs.map((log, i) => Math.log(top[i] + rest[i] + DARK_OFFSET) - log);
  }

  /** A code after one step. */
  private corrected(code: Float32Array, top: Float64Array, logs: Float64Array): Float32Array {
    const size = this.weights.arch.rest;
    const found = this.slopes.at(code, this.weights.arch.lobe, this.fittedResponses);
    const curvature = new Float64Array(size * size);
    const slope = new Float64Array(size);
    for (let place = 0; place < found.rest.length; place++) {
      const rest = found.rest[place];
      const f = top[2 * place] + rest + DARK_OFFSET;
      const error = Math.log(f) - logs[2 * place];
      const share = rest / f;
      const far = farness(error);
      addRow(
        slope,
        curvature,
        found.slopes,
        place * size,
        (error * share) / far,
        (share * share) / far,
      );
    }
    const step = dampedStep(curvature, slope, CORRECTION_DAMPING);
    const { lobe } = this.weights.arch;
    return code.map((number, k) => (k < lobe ? number : number - step[k - lobe]));
  }
}

function everySecond(pairs: Pairs): Pairs {
  const kept = pairs.directions.filter((_, k) => Math.floor(k / 6) % 2 === 0);
  const of = (start: number) => kept.filter((_, k) => (k - start + 6) % 6 < 3);
  return Pairs.of(of(0), of(3), pairs.widths);
}

/** The factor by which an error's weight is reduced. */
export function farness(error: number): number {
  return Math.max(Math.abs(error) / FIT.HUBER_KNEE, 1);
}

function totalLoss(errors: Float64Array): number {
  return errors.reduce((sum, error) => {
    const far = farness(error);
    return sum + (error * error * (2 - 1 / far)) / far;
  }, 0);
}
