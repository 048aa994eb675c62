/** Derivatives of the decoder by the numbers of a code, by which codes are fitted to values. */

import { clampedLog, type Decoder, LANES, type PreparedCode, type Responses } from "./decoder";
import { activateWithSlope, linear } from "./mlp";
import { first, type Layer, last } from "./weights";

/** Values of the rest at pairs, and derivatives (count, R) of their logarithms by its numbers. */
export interface Slopes {
  readonly rest: Float64Array;
  readonly slopes: Float64Array;
}

export class DecoderSlopes {
  private readonly codes: number;
  private readonly entry: Layer;
  private readonly output: Layer;
  /** Hidden layers after the first. */
  private readonly hidden: readonly Layer[];
  /** Of every hidden layer: its activations, their slopes, and derivatives of the output. */
  private readonly states: readonly Float64Array[];
  private readonly slopesOfStates: readonly Float64Array[];
  private readonly gradients: readonly Float64Array[];
  private readonly value = new Float64Array(1);

  constructor(private readonly decoder: Decoder) {
    const layers = decoder.weights.decoder;
    this.codes = decoder.weights.arch.codes;
    this.entry = first(layers);
    this.output = last(layers);
    this.hidden = layers.slice(1, -1);
    const ofLayers = () => layers.slice(0, -1).map(({ outputs }) => new Float64Array(outputs));
    this.states = ofLayers();
    this.slopesOfStates = ofLayers();
    this.gradients = ofLayers();
  }

  /** The rest at all pairs, and the derivatives of its logarithm by the code's numbers. */
  at(numbers: ArrayLike<number>, rest: number, responses: Responses): Slopes {
    const code = this.decoder.prepare(numbers, rest);
    const size = 1 + this.codes;
    const values = new Float64Array(responses.count);
    const slopes = new Float64Array(values.length * size);
    for (let i = 0; i < values.length; i++) {
      slopes[i * size] = 1;
      values[i] = Math.exp(clampedLog(this.pullback(code, responses, i, slopes, i * size + 1)));
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
    const { states, slopesOfStates, hidden, entry } = this;
    const { activation, weights } = this.decoder;
    const width = entry.outputs;
    const block = Math.floor(i / LANES) * LANES * width + (i % LANES);
    for (let j = 0; j < width; j++) {
      states[0][j] = code.offset[j] + code.factor[j] * responses.values[block + j * LANES];
    }
    activateWithSlope(states[0], slopesOfStates[0], width, activation);
    for (let index = 0; index < hidden.length; index++) {
      const next = states[index + 1];
      linear(hidden[index], states[index], next, 1);
      activateWithSlope(next, slopesOfStates[index + 1], next.length, activation);
    }
    linear(this.output, last(states), this.value, 1);

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
      for (let j = 0; j < width; j++) {
        const response = responses.values[block + j * LANES];
        const weight = entry.weight[j * entry.inputs + k];
        sum += gradient[j] * (weight + response * weights.scale[j * this.codes + k]);
      }
      slopes[place + k] = sum;
    }
    return code.gain + this.value[0];
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
