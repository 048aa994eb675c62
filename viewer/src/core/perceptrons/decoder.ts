/** The decoder: from a code and pairs of directions to the BRDF without its topmost lobe. */

import { clampedLog } from "../f_table";
import type { Pairs } from "../features";
import { directionFeatures2, FEATURES } from "../formulas";
import { first, type Layer, last } from "../layers";
import { type Activation, activate } from "../mlp";
import type { AtPairs } from "../rests";
import type { PerceptronWeights } from "./weights";

/** What the decoder needs of one code: how it shifts and scales the first layer, and its gain. */
export interface PreparedCode {
  readonly offset: Float64Array;
  readonly factor: Float64Array;
  readonly gain: number;
}

/** Number of pairs that are evaluated at once, so that each weight is read once for them. */
const LANES = 4;

export class Decoder {
  /** Neurons of the first layer. */
  private readonly width: number;
  /** Inputs of the network that belong to the code. */
  private readonly codes: number;
  private readonly entry: Layer;
  private readonly output: Layer;
  /** Numbers of a pair's features, and the entry's weights of these alone: (width, features). */
  private readonly features: number;
  private readonly ofDirections: Float64Array;
  /** Hidden layers after the first, and the activations (units, `LANES`) behind every layer. */
  private readonly hidden: readonly Layer[];
  private readonly states: readonly Float64Array[];

  constructor(
    private readonly weights: PerceptronWeights,
    private readonly activation: Activation,
  ) {
    this.entry = first(weights.decoder);
    this.output = last(weights.decoder);
    this.hidden = weights.decoder.slice(1, -1);
    this.codes = weights.arch.rest - 1;
    this.width = this.entry.outputs;
    const layers = weights.decoder.slice(0, -1);
    this.states = layers.map(({ outputs }) => new Float64Array(outputs * LANES));
    this.features = this.entry.inputs - this.codes;
    this.ofDirections = new Float64Array(this.width * this.features);
    for (let j = 0; j < this.width; j++) {
      const at = j * this.entry.inputs + this.codes;
      const row = this.entry.weight.subarray(at, at + this.features);
      this.ofDirections.set(row, j * this.features);
    }
  }

  /** Prepare the code whose rest begins at a place of an array. */
  prepare(code: ArrayLike<number>, rest: number): PreparedCode {
    const offset = new Float64Array(this.width);
    const factor = new Float64Array(this.width);
    const { scale } = this.weights;
    for (let j = 0; j < this.width; j++) {
      let o = this.entry.bias[j];
      let s = 1;
      for (let k = 0; k < this.codes; k++) {
        const z = code[rest + 1 + k];
        o += this.entry.weight[j * this.entry.inputs + k] * z;
        s += scale[j * this.codes + k] * z;
      }
      offset[j] = o;
      factor[j] = s;
    }
    return { offset, factor, gain: code[rest] };
  }

  /**
   * The first layer's responses to the first `count` pairs, the same for all codes: (blocks, width,
   * `LANES`), where the pairs of a block lie side by side. The last block is filled up.
   */
  respond(pairs: Pairs, count: number): AtPairs {
    const { directions: w } = pairs;
    const { width, ofDirections, features: stride } = this;
    const features = new Float64Array(count * FEATURES.DIRECTION_FEATURES[2]);
    for (let i = 0, k = 0; i < count; i++, k += 6)
      directionFeatures2(
        w[k],
        w[k + 1],
        w[k + 2],
        w[k + 3],
        w[k + 4],
        w[k + 5],
        features,
        i * stride,
      );
    const values = new Float64Array(Math.ceil(count / LANES) * LANES * width);
    for (let i = 0; i < count; i++) {
      const at = i * stride;
      const a = features[at];
      const b = features[at + 1];
      const c = features[at + 2];
      const d = features[at + 3];
      const e = features[at + 4];
      const f = features[at + 5];
      const g = features[at + 6];
      const h = features[at + 7];
      let place = Math.floor(i / LANES) * LANES * width + (i % LANES);
      const first = place;
      for (let w = 0; w < ofDirections.length; w += stride, place += LANES) {
        values[place] =
          a * ofDirections[w] +
          b * ofDirections[w + 1] +
          (c * ofDirections[w + 2] + d * ofDirections[w + 3]) +
          (e * ofDirections[w + 4] + f * ofDirections[w + 5]) +
          (g * ofDirections[w + 6] + h * ofDirections[w + 7]);
      }
      for (let k = 8; k < stride; k++) {
        const feature = features[at + k];
        for (let w = k, to = first; w < ofDirections.length; w += stride, to += LANES) {
          values[to] += feature * ofDirections[w];
        }
      }
    }
    return { pairs, count, values };
  }

  /** The rest [1/sr] at all pairs. */
  rest(code: PreparedCode, responses: AtPairs): Float64Array {
    const result = new Float64Array(responses.count);
    const lanes = new Float64Array(LANES);
    for (let start = 0; start < result.length; start += LANES) {
      this.evaluate(code, responses.values, start * this.width, lanes);
      const end = Math.min(start + LANES, result.length);
      for (let i = start; i < end; i++) {
        result[i] = Math.exp(clampedLog(code.gain + lanes[i - start]));
      }
    }
    return result;
  }

  /** The network's outputs for the block of responses that begins at a place. */
  private evaluate(
    { offset, factor }: PreparedCode,
    responses: Float64Array,
    at: number,
    output: Float64Array,
  ): void {
    let state = this.states[0];
    for (let j = 0, k = 0; j < offset.length; j++, k += LANES) {
      const o = offset[j];
      const s = factor[j];
      state[k] = o + s * responses[at + k];
      state[k + 1] = o + s * responses[at + k + 1];
      state[k + 2] = o + s * responses[at + k + 2];
      state[k + 3] = o + s * responses[at + k + 3];
    }
    activate(state, state.length, this.activation);
    for (let layer = 0; layer < this.hidden.length; layer++) {
      const next = this.states[layer + 1];
      linearOfBlock(this.hidden[layer], state, next);
      activate(next, next.length, this.activation);
      state = next;
    }
    linearOfBlock(this.output, state, output);
  }
}

/** One layer for inputs (inputs, `LANES`), two outputs at a time. */
function linearOfBlock(layer: Layer, x: Float64Array, y: Float64Array): void {
  const { inputs, outputs, weight, bias } = layer;
  for (let j = 0; j < outputs; j += 2) {
    const isPair = j + 1 < outputs;
    const first = j * inputs;
    const second = isPair ? first + inputs : first;
    let a0 = bias[j];
    let a1 = a0;
    let a2 = a0;
    let a3 = a0;
    let b0 = isPair ? bias[j + 1] : 0;
    let b1 = b0;
    let b2 = b0;
    let b3 = b0;
    for (let i = 0, k = 0; i < inputs; i++, k += LANES) {
      const v = weight[first + i];
      const w = weight[second + i];
      const x0 = x[k];
      const x1 = x[k + 1];
      const x2 = x[k + 2];
      const x3 = x[k + 3];
      a0 += v * x0;
      a1 += v * x1;
      a2 += v * x2;
      a3 += v * x3;
      b0 += w * x0;
      b1 += w * x1;
      b2 += w * x2;
      b3 += w * x3;
    }
    const place = j * LANES;
    y[place] = a0;
    y[place + 1] = a1;
    y[place + 2] = a2;
    y[place + 3] = a3;
    if (isPair) {
      y[place + 4] = b0;
      y[place + 5] = b1;
      y[place + 6] = b2;
      y[place + 7] = b3;
    }
  }
}
