/** The decoder: from a code and pairs of directions to the BRDF without its topmost lobe. */

import { DIRECTION_FEATURES, type Pairs } from "./features";
import { type Activation, activate, activateWithSlope } from "./mlp";
import { first, type Layer, last, type Weights } from "./weights";

/** Range of ln f. */
const MIN_LOG = -25;
const MAX_LOG = 20;

/** Gain with which any code decodes to exp(`MIN_LOG`). */
const EMPTY_GAIN = -100;

/** What the decoder needs of one code: how it shifts and scales the first layer, and its gain. */
export interface PreparedCode {
  readonly offset: Float64Array;
  readonly factor: Float64Array;
  readonly gain: number;
}

/** The first layer's response to pairs of directions, the same for all codes: (count, width). */
export type Responses = Float64Array;

/** Values of the rest at pairs, and derivatives (count, R) of their logarithms by its numbers. */
export interface Slopes {
  readonly rest: Float64Array;
  readonly slopes: Float64Array;
}

export class Decoder {
  /** Neurons of the first layer. */
  readonly width: number;
  private readonly codes: number;
  private readonly entry: Layer;
  private readonly output: Layer;
  private readonly scale: Float64Array;
  /** The entry's weights of the directions alone: (width, 8). */
  private readonly ofDirections: Float64Array;
  /** Hidden layers after the first, and the activations behind every layer. */
  private readonly hidden: readonly Layer[];
  private readonly states: readonly Float64Array[];
  private readonly slopesOfStates: readonly Float64Array[];
  private readonly gradients: readonly Float64Array[];

  constructor(
    weights: Weights,
    private readonly activation: Activation,
  ) {
    this.entry = first(weights.decoder);
    this.output = last(weights.decoder);
    this.hidden = weights.decoder.slice(1, -1);
    this.codes = weights.arch.codes;
    this.width = this.entry.outputs;
    this.scale = weights.scale;
    const widths = weights.decoder.slice(0, -1).map((layer) => layer.outputs);
    this.states = widths.map((width) => new Float64Array(width));
    this.slopesOfStates = widths.map((width) => new Float64Array(width));
    this.gradients = widths.map((width) => new Float64Array(width));
    this.ofDirections = new Float64Array(this.width * DIRECTION_FEATURES);
    for (let j = 0; j < this.width; j++) {
      const at = j * this.entry.inputs + this.codes;
      const row = this.entry.weight.subarray(at, at + DIRECTION_FEATURES);
      this.ofDirections.set(row, j * DIRECTION_FEATURES);
    }
  }

  /** Prepare the code whose rest begins at a place of an array. */
  prepare(code: ArrayLike<number>, rest: number): PreparedCode {
    const offset = new Float64Array(this.width);
    const factor = new Float64Array(this.width);
    for (let j = 0; j < this.width; j++) {
      let o = this.entry.bias[j];
      let s = 1;
      for (let k = 0; k < this.codes; k++) {
        const z = code[rest + 1 + k];
        o += this.entry.weight[j * this.entry.inputs + k] * z;
        s += this.scale[j * this.codes + k] * z;
      }
      offset[j] = o;
      factor[j] = s;
    }
    return { offset, factor, gain: code[rest] };
  }

  /** The first layer's responses to the first `count` pairs. */
  respond(pairs: Pairs, count = pairs.capacity, out?: Responses): Responses {
    const { width, ofDirections } = this;
    const { features } = pairs;
    const result = out ?? new Float64Array(count * width);
    for (let i = 0; i < count; i++) {
      const at = i * DIRECTION_FEATURES;
      const a = features[at];
      const b = features[at + 1];
      const c = features[at + 2];
      const d = features[at + 3];
      const e = features[at + 4];
      const f = features[at + 5];
      const g = features[at + 6];
      const h = features[at + 7];
      for (let j = 0, w = 0; j < width; j++, w += DIRECTION_FEATURES) {
        result[i * width + j] =
          a * ofDirections[w] +
          b * ofDirections[w + 1] +
          (c * ofDirections[w + 2] + d * ofDirections[w + 3]) +
          (e * ofDirections[w + 4] + f * ofDirections[w + 5]) +
          (g * ofDirections[w + 6] + h * ofDirections[w + 7]);
      }
    }
    return result;
  }

  /** The rest [1/sr] at pair `i`. */
  rest(code: PreparedCode, responses: Responses, i: number): number {
    return Math.exp(clamped(this.logarithm(code, responses, i)));
  }

  private logarithm(code: PreparedCode, responses: Responses, i: number): number {
    let state = this.states[0];
    this.enter(code, responses, i, state);
    activate(state, this.width, this.activation);
    for (let layer = 0; layer < this.hidden.length; layer++) {
      const next = this.states[layer + 1];
      step(this.hidden[layer], state, next);
      activate(next, next.length, this.activation);
      state = next;
    }
    return code.gain + outputOf(this.output, state);
  }

  private enter(code: PreparedCode, responses: Responses, i: number, state: Float64Array): void {
    const { offset, factor } = code;
    const at = i * this.width;
    for (let j = 0; j < this.width; j++) {
      state[j] = offset[j] + factor[j] * responses[at + j];
    }
  }

  /** The rest at all pairs, and the derivatives of its logarithm by the code's numbers. */
  restWithSlopes(numbers: ArrayLike<number>, rest: number, responses: Responses): Slopes {
    const code = this.prepare(numbers, rest);
    const size = 1 + this.codes;
    const values = new Float64Array(responses.length / this.width);
    const slopes = new Float64Array(values.length * size);
    for (let i = 0; i < values.length; i++) {
      slopes[i * size] = 1;
      values[i] = Math.exp(clamped(this.pullback(code, responses, i, slopes, i * size + 1)));
    }
    return { rest: values, slopes };
  }

  /** The network's logarithm at pair `i`, and its derivatives by its inputs of the code. */
  private pullback(
    code: PreparedCode,
    responses: Responses,
    i: number,
    slopes: Float64Array,
    place: number,
  ): number {
    const { states, slopesOfStates, hidden } = this;
    this.enter(code, responses, i, states[0]);
    activateWithSlope(states[0], slopesOfStates[0], this.width, this.activation);
    for (let index = 0; index < hidden.length; index++) {
      const next = states[index + 1];
      step(hidden[index], states[index], next);
      activateWithSlope(next, slopesOfStates[index + 1], next.length, this.activation);
    }
    const logarithm = code.gain + outputOf(this.output, last(states));

    const gradient = this.gradients[0];
    const atOutput = last(this.gradients);
    const outputSlopes = last(slopesOfStates);
    for (let j = 0; j < atOutput.length; j++) {
      atOutput[j] = outputSlopes[j] * this.output.weight[j];
    }
    for (let layer = hidden.length - 1; layer >= 0; layer--) {
      stepBack(hidden[layer], this.gradients[layer + 1], this.gradients[layer]);
      multiply(this.gradients[layer], slopesOfStates[layer]);
    }
    for (let k = 0; k < this.codes; k++) {
      let sum = 0;
      for (let j = 0; j < this.width; j++) {
        const response = responses[i * this.width + j];
        const weight = this.entry.weight[j * this.entry.inputs + k];
        sum += gradient[j] * (weight + response * this.scale[j * this.codes + k]);
      }
      slopes[place + k] = sum;
    }
    return logarithm;
  }
}

function clamped(logarithm: number): number {
  return Math.min(Math.max(logarithm, MIN_LOG), MAX_LOG);
}

/** One layer for one input. Four sums at once, because a sum waits for its last addition. */
function step(layer: Layer, x: Float64Array, y: Float64Array): void {
  const { inputs, outputs, weight, bias } = layer;
  const whole = outputs & ~3;
  for (let j = 0; j < whole; j += 4) {
    let a = bias[j];
    let b = bias[j + 1];
    let c = bias[j + 2];
    let d = bias[j + 3];
    const first = j * inputs;
    const second = first + inputs;
    const third = second + inputs;
    const fourth = third + inputs;
    for (let i = 0; i < inputs; i++) {
      const value = x[i];
      a += weight[first + i] * value;
      b += weight[second + i] * value;
      c += weight[third + i] * value;
      d += weight[fourth + i] * value;
    }
    y[j] = a;
    y[j + 1] = b;
    y[j + 2] = c;
    y[j + 3] = d;
  }
  for (let j = whole; j < outputs; j++) {
    let sum = bias[j];
    for (let i = 0; i < inputs; i++) {
      sum += weight[j * inputs + i] * x[i];
    }
    y[j] = sum;
  }
}

/** Derivatives x by a layer's inputs of those y by its outputs. */
function stepBack(layer: Layer, y: Float64Array, x: Float64Array): void {
  const { inputs, outputs, weight } = layer;
  x.fill(0);
  for (let j = 0; j < outputs; j++) {
    const factor = y[j];
    for (let i = 0; i < inputs; i++) {
      x[i] += factor * weight[j * inputs + i];
    }
  }
}

function multiply(x: Float64Array, factors: Float64Array): void {
  for (let i = 0; i < x.length; i++) {
    x[i] *= factors[i];
  }
}

function outputOf(layer: Layer, x: Float64Array): number {
  let sum = layer.bias[0];
  for (let i = 0; i < layer.inputs; i++) {
    sum += layer.weight[i] * x[i];
  }
  return sum;
}

/** Multiply the rest at a place by a factor > 0, exactly for all directions. */
export function scaleRest(code: Float32Array, rest: number, factor: number): void {
  code[rest] += Math.log(factor);
}

/** Make the rest at a place nothing. */
export function emptyRest(code: Float32Array, rest: number): void {
  code[rest] = EMPTY_GAIN;
}
