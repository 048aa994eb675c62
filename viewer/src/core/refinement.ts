/**
 * Refinement of codes: an optimisation that brings decoded values closer to given ones.
 *
 * The objective is the error of ln f and the distance from the codes that the encoder makes, since
 * only those can be coated; see Python's `material.fit`, whose terms these are.
 */

import { albedosAtAngles, interpolatedAlbedos } from "./albedo_rule";
import { type Decoder, type Responses, scaleRest } from "./decoder";
import type { Encoder } from "./encoder";
import type { EnergyLimit } from "./energy";
import { ENCODER, ENERGY, ERROR_METRICS, FIT, LOBE } from "./formulas";
import { addRow, dampedSteps, type FitState, solve } from "./least_squares";
import { lobeValues } from "./lobe";
import type { Activation } from "./mlp";
import { DecoderSlopes, EncoderSlopes } from "./slopes";
import type { Weights } from "./weights";

const { INITIAL_ALPHAS, INITIAL_WHITE_SHARES, REFINEMENT_STEPS, ANCHOR_HOLD, CODE_HOLD } = FIT;
const { NODES_SHARE, NODES_POWER, CEILING_ROUNDS, CEILING_STEPS, LEAST_VARIANCE } = FIT;
const { LEAST_ALBEDO } = ENERGY;
const { OFFSET } = ENCODER;
const { COSINE_FLOOR, DARK_OFFSET } = ERROR_METRICS;

/** Target values at the probe pairs and the albedo nodes. */
interface Target {
  /** ln(f + offset), weights that add up to one, and the lobe's part of f. */
  readonly logs: Float64Array;
  readonly weights: Float64Array;
  readonly top: Float64Array;
}

export class Refinement {
  private readonly slopes: DecoderSlopes;
  private readonly encoderSlopes: EncoderSlopes;
  /** Of the probe pairs, and of the albedo nodes. */
  private readonly responses: readonly [Responses, Responses];
  private readonly probes: number;
  private surfaces: Float32Array[] | undefined;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
    private readonly decoder: Decoder,
    private readonly encoder: Encoder,
    private readonly energy: EnergyLimit,
  ) {
    this.slopes = new DecoderSlopes(decoder);
    this.encoderSlopes = new EncoderSlopes(weights, activation);
    this.responses = [decoder.respond(encoder.pairs), decoder.respond(energy.rule.pairs)];
    this.probes = encoder.pairs.capacity;
  }

  /** The code and the anchor of values [1/sr] at the probe pairs and the albedo nodes. */
  refine(
    lobe: Float32Array,
    probed: Float64Array,
    nodes: Float64Array,
  ): { code: Float32Array; anchor: Float32Array } {
    const target = this.targetOf(lobe, probed, nodes);
    const start = this.initialCode(lobe, probed);
    const anchor = this.fitBelowCeiling(start, target, ANCHOR_HOLD);
    return { anchor, code: this.fitBelowCeiling(anchor, target, CODE_HOLD) };
  }

  /** Errors at the probe pairs over f [1/sr]: of the lobe alone, and of a code over those. */
  errorsOf(code: Float32Array, f: Float64Array): { alone: number; relative: number } {
    const { encoder, decoder } = this;
    const { pairs } = encoder;
    const lobe = this.weights.arch.lobe;
    const top = lobeValues(code.subarray(0, lobe), pairs);
    const rest = decoder.rest(decoder.prepare(code, lobe), this.responses[0]);
    let [light, alone, own] = [0, 0, 0];
    f.forEach((value, i) => {
      const [cosI, cosO] = [pairs.directions[6 * i + 2], pairs.directions[6 * i + 5]];
      const weight = Math.max(cosI, COSINE_FLOOR) * Math.max(cosO, COSINE_FLOOR);
      light += weight * value;
      alone += weight * Math.abs(value - top[i]);
      own += weight * Math.abs(value - top[i] - rest[i]);
    });
    return { alone: alone / light, relative: own / Math.max(alone, LEAST_ALBEDO) };
  }

  private targetOf(lobe: Float32Array, probed: Float64Array, nodes: Float64Array): Target {
    const { rule } = this.energy;
    const logOf = (value: number) => Math.log(value + DARK_OFFSET);
    // The rule's weights hold wo's cosine, the shares those of both.
    const light = nodes.map(
      (value, i) => value * rule.weights[i] * rule.pairs.directions[6 * i + 2],
    );
    const shares = light.map((value) => Math.max(value, 0) ** NODES_POWER);
    const sum = shares.reduce((a, b) => a + b, 0);
    const share = sum > 0 ? NODES_SHARE : 0;
    const even = (1 - share) / this.probes;
    return {
      logs: Float64Array.of(...probed.map(logOf), ...nodes.map(logOf)),
      weights: Float64Array.of(
        ...probed.map(() => even),
        ...shares.map((value) => (sum > 0 ? (share * value) / sum : 0)),
      ),
      top: Float64Array.of(
        ...lobeValues(lobe, this.encoder.pairs),
        ...lobeValues(lobe, rule.pairs),
      ),
    };
  }

  /** The best of the encoder's code and codes of plain surfaces, which are scaled to f. */
  private initialCode(lobe: Float32Array, f: Float64Array): Float32Array {
    const { encoder, decoder } = this;
    const top = lobeValues(lobe, encoder.pairs);
    const logs = f.map((value) => Math.log(value + DARK_OFFSET));
    const restLogs = f.map((value, i) => Math.log(Math.max(value - top[i], 0) + DARK_OFFSET));
    const restOf = (code: Float32Array) =>
      decoder.rest(decoder.prepare(code, this.weights.arch.lobe), this.responses[0]);
    const candidates = [encoder.encode(lobe, difference(f, top))];
    for (const plain of this.plainCodes()) {
      const code = plain.slice();
      const rest = restOf(code);
      const gain = median(restLogs.map((log, i) => log - Math.log(rest[i] + DARK_OFFSET)));
      scaleRest(code, this.weights.arch.lobe, Math.exp(gain));
      code.set(lobe);
      candidates.push(code);
    }
    let best = candidates[0];
    let least = Number.POSITIVE_INFINITY;
    for (const code of candidates) {
      const rest = restOf(code);
      let error = 0;
      for (let i = 0; i < logs.length; i++) {
        error += Math.abs(Math.log(top[i] + rest[i] + DARK_OFFSET) - logs[i]);
      }
      if (error < least) {
        [best, least] = [code, error];
      }
    }
    return best;
  }

  /** Codes of a white diffuse surface and of conductors over shares of it. */
  private plainCodes(): readonly Float32Array[] {
    if (!this.surfaces) {
      const { encoder } = this;
      const white = new Float64Array(this.probes).fill(1 / Math.PI);
      this.surfaces = [encoder.encode(LOBE.NO_LOBE, white)];
      for (const alpha of INITIAL_ALPHAS) {
        const metal = lobeValues([alpha, 0.9, 1, 0, 1.5, 0], encoder.pairs);
        for (const share of INITIAL_WHITE_SHARES) {
          const values = metal.map((value) => value + share / Math.PI);
          this.surfaces.push(encoder.encode(LOBE.NO_LOBE, values));
        }
      }
    }
    return this.surfaces;
  }

  /** `descend`, repeated with lower targets at angles where the code is too bright. */
  private fitBelowCeiling(start: Float32Array, target: Target, hold: number): Float32Array {
    const { energy, probes } = this;
    const { rule } = energy;
    const rest = target.logs.map((log, i) =>
      Math.max(Math.exp(log) - DARK_OFFSET - target.top[i], 0),
    );
    const own = albedosAtAngles(rule, rest.subarray(probes)).map((x) => Math.max(x, LEAST_ALBEDO));
    const ceiling = energy.restCeiling(start, interpolatedAlbedos(rule, own));
    const lower = { ...target, logs: target.logs.slice() };
    let code = start;
    let best = start;
    let least = Number.POSITIVE_INFINITY;
    const rounds = [REFINEMENT_STEPS, ...Array<number>(CEILING_ROUNDS).fill(CEILING_STEPS), 0];
    rounds.forEach((steps, round) => {
      const decoded = this.restOf(code);
      const bright = albedosAtAngles(rule, decoded.subarray(probes));
      const interpolated = interpolatedAlbedos(rule, bright);
      let factor = 1;
      ceiling.forEach((allowed, d) => {
        factor = Math.min(factor, allowed / Math.max(interpolated[d], LEAST_ALBEDO));
      });
      let error = 0;
      target.logs.forEach((log, i) => {
        const value = target.top[i] + factor * decoded[i] + DARK_OFFSET;
        error += target.weights[i] * Math.abs(Math.log(value) - log);
      });
      if (error < least) {
        [best, least] = [code, error];
      }
      if (steps === 0) {
        return;
      }
      if (round > 0) {
        own.forEach((albedo, k) => {
          const excess = Math.max(bright[k] / albedo, 1);
          for (let i = rule.bounds[k]; i < rule.bounds[k + 1]; i++) {
            const at = probes + i;
            rest[at] /= excess;
            lower.logs[at] = Math.log(target.top[at] + rest[at] + DARK_OFFSET);
          }
        });
      }
      code = this.descend(code, lower, hold, steps);
    });
    return best;
  }

  /** The code after damped steps. */
  private descend(code: Float32Array, target: Target, hold: number, steps: number): Float32Array {
    const { lobe } = this.weights.arch;
    const stateAt = (x: Float32Array) => this.stateAt(x, target, hold);
    return dampedSteps(stateAt, code, steps, FIT.DAMPING, (x, step) =>
      x.map((number, k) => (k < lobe ? number : number - step[k - lobe])),
    ).x;
  }

  /** Values of the rest at the probe pairs and the albedo nodes. */
  private restOf(code: Float32Array): Float64Array {
    const prepared = this.decoder.prepare(code, this.weights.arch.lobe);
    const parts = this.responses.map((responses) => this.decoder.rest(prepared, responses).slice());
    return Float64Array.of(...parts[0], ...parts[1]);
  }

  /** The objective at a code, half its gradient and half its Hessian by Gauss and Newton. */
  private stateAt(code: Float32Array, target: Target, hold: number): FitState<Float32Array> {
    const { probes } = this;
    const size = this.weights.arch.rest;
    const slope = new Float64Array(size);
    const curvature = new Float64Array(size * size);
    let objective = 0;
    const [atProbes, atNodes] = this.responses.map((responses) =>
      this.slopes.at(code, this.weights.arch.lobe, responses),
    );
    for (const [part, first] of [
      [atProbes, 0],
      [atNodes, probes],
    ] as const) {
      for (let i = 0; i < part.rest.length; i++) {
        const at = first + i;
        const f = target.top[at] + part.rest[i] + DARK_OFFSET;
        const error = Math.log(f) - target.logs[at];
        const far = Math.max(Math.abs(error) / FIT.HUBER_KNEE, 1);
        const share = part.rest[i] / f;
        objective += (target.weights[at] * error * error * (2 - 1 / far)) / far;
        const weight = target.weights[at] / far;
        addRow(
          slope,
          curvature,
          part.slopes,
          i * size,
          weight * error * share,
          weight * share * share,
        );
      }
    }
    objective += this.addDistance(code, atProbes, hold / probes, slope, curvature);
    return { x: code, objective, slope, curvature };
  }

  /**
   * Add the distance from the encoder's codes to slope and curvature, and return it.
   *
   * The encoder's Jacobian J maps a change d of what it sees to the change J d of its code. The
   * smallest d that closes the gap g between a code and the encoder's has the square
   * g' (J J')^-1 g. Its derivatives neglect the change of J.
   */
  private addDistance(
    code: Float32Array,
    decoded: { readonly rest: Float64Array; readonly slopes: Float64Array },
    hold: number,
    slope: Float64Array,
    curvature: Float64Array,
  ): number {
    const { probes } = this;
    const size = slope.length;
    const logs = decoded.rest.map((value) => Math.log(Math.max(value, 0) + OFFSET));
    const { numbers, slopes: inward } = this.encoderSlopes.at(logs);
    const variance = new Float64Array(size * size);
    // (size, 1 + size): the gap, and its derivatives by the code's numbers
    const width = 1 + size;
    const gaps = new Float64Array(size * width);
    const seen = decoded.rest.map((value) => value / (value + OFFSET));
    for (let a = 0; a < size; a++) {
      gaps[a * width] = code[this.weights.arch.lobe + a] - numbers[a];
      gaps[a * width + 1 + a] = 1;
      for (let i = 0; i < probes; i++) {
        const factor = inward[a * probes + i];
        for (let b = 0; b <= a; b++) {
          variance[a * size + b] += factor * inward[b * probes + i];
        }
        for (let b = 0; b < size; b++) {
          gaps[a * width + 1 + b] -= factor * decoded.slopes[i * size + b] * seen[i];
        }
      }
    }
    let trace = 0;
    for (let a = 0; a < size; a++) {
      trace += variance[a * size + a];
      for (let b = 0; b < a; b++) {
        variance[b * size + a] = variance[a * size + b];
      }
    }
    for (let a = 0; a < size; a++) {
      variance[a * size + a] += (LEAST_VARIANCE * trace) / size;
    }
    const whitened = solve(variance, gaps.slice(), size);
    let distance = 0;
    for (let k = 0; k < size; k++) {
      const row = k * width;
      distance += hold * gaps[row] * whitened[row];
      for (let a = 0; a < size; a++) {
        const factor = hold * gaps[row + 1 + a];
        slope[a] += factor * whitened[row];
        for (let b = 0; b < size; b++) {
          curvature[a * size + b] += factor * whitened[row + 1 + b];
        }
      }
    }
    return distance;
  }
}

/** What a lobe leaves of f, at least zero. */
export function difference(f: Float64Array, top: Float64Array): Float64Array {
  return f.map((value, i) => Math.max(value - top[i], 0));
}

function median(values: Float64Array): number {
  const sorted = values.slice().sort();
  const middle = sorted.length >> 1;
  return sorted.length % 2 ? sorted[middle] : (sorted[middle - 1] + sorted[middle]) / 2;
}
