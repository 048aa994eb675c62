/** Derivatives of the networks by their inputs, by which codes are fitted to values. */

import { clampedLog, type Decoder, LANES, type Responses } from "./decoder";
import { type Activation, activateWithSlope, linear } from "./mlp";
import { first, type Layer, last, type Weights } from "./weights";

/** Outputs of layers and their derivatives; results are valid until the next evaluation. */
class NetworkSlopes {
  /** Of every layer: its outputs, their slopes, and derivatives (last outputs, its inputs). */
  private readonly states: readonly Float64Array[];
  private readonly slopes: readonly Float64Array[];
  private readonly gradients: readonly Float64Array[];

  constructor(
    private readonly layers: readonly Layer[],
    private readonly activation: Activation,
  ) {
    const rows = last(layers).outputs;
    this.states = layers.map(({ outputs }) => new Float64Array(outputs));
    this.slopes = layers.map(({ outputs }) => new Float64Array(outputs));
    this.gradients = layers.map(({ inputs }) => new Float64Array(rows * inputs));
    last(this.gradients).set(last(layers).weight);
  }

  /** The outputs (R) for inputs (N), and derivatives (R, N). */
  at(x: Float64Array): { outputs: Float64Array; slopes: Float64Array } {
    const { layers, states, gradients } = this;
    layers.forEach((layer, index) => {
      linear(layer, index === 0 ? x : states[index - 1], states[index], 1);
      if (index + 1 < layers.length)
        activateWithSlope(states[index], this.slopes[index], layer.outputs, this.activation);
    });
    for (let index = layers.length - 2; index >= 0; index--)
      stepBack(layers[index], this.slopes[index], gradients[index + 1], gradients[index]);
    return { outputs: last(states), slopes: gradients[0] };
  }
}

/** Derivatives (R, inputs) by a layer's inputs of those (R, outputs) by its activations. */
function stepBack(layer: Layer, slopes: Float64Array, from: Float64Array, to: Float64Array): void {
  const { inputs, outputs, weight } = layer;
  to.fill(0);
  for (let at = 0, place = 0; at < from.length; at += outputs, place += inputs) {
    for (let j = 0; j < outputs; j++) {
      const factor = from[at + j] * slopes[j];
      for (let i = 0; i < inputs; i++) to[place + i] += factor * weight[j * inputs + i];
    }
  }
}

/** The encoder's rests of codes (R) for logarithms (P), and derivatives (R, P) by these. */
export class EncoderSlopes {
  private readonly network: NetworkSlopes;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new NetworkSlopes(weights.encoder, activation);
  }

  at(logs: Float64Array): { numbers: Float64Array; slopes: Float64Array } {
    const { inputMean, inputScale } = this.weights;
    const { outputs, slopes } = this.network.at(
      logs.map((log, i) => (log - inputMean[i]) / inputScale[i]),
    );
    return { numbers: outputs, slopes: slopes.map((x, at) => x / inputScale[at % logs.length]) };
  }
}

/** Values of the rest at pairs, and derivatives (count, R) of their logarithms by its numbers. */
export interface RestSlopes {
  readonly rest: Float64Array;
  readonly slopes: Float64Array;
}

export class DecoderSlopes {
  private readonly entry: Layer;
  private readonly network: NetworkSlopes;
  /** The first layer's activations and their slopes. */
  private readonly state: Float64Array;
  private readonly slopes: Float64Array;

  constructor(private readonly decoder: Decoder) {
    const layers = decoder.weights.decoder;
    this.entry = first(layers);
    this.network = new NetworkSlopes(layers.slice(1), decoder.activation);
    this.state = new Float64Array(this.entry.outputs);
    this.slopes = new Float64Array(this.entry.outputs);
  }

  /** The rest at all pairs, and the derivatives of its logarithm by the code's numbers. */
  at(numbers: ArrayLike<number>, rest: number, responses: Responses): RestSlopes {
    const { entry, decoder, state } = this;
    const { activation, weights } = decoder;
    const { offset, factor, gain } = decoder.prepare(numbers, rest);
    const [width, codes] = [entry.outputs, weights.arch.codes];
    const values = new Float64Array(responses.count);
    const result = new Float64Array(values.length * (1 + codes));
    for (let i = 0; i < values.length; i++) {
      const block = Math.floor(i / LANES) * LANES * width + (i % LANES);
      for (let j = 0; j < width; j++)
        state[j] = offset[j] + factor[j] * responses.values[block + j * LANES];
      activateWithSlope(state, this.slopes, width, activation);
      const found = this.network.at(state);
      values[i] = Math.exp(clampedLog(gain + found.outputs[0]));
      const place = i * (1 + codes);
      result[place] = 1;
      for (let j = 0; j < width; j++) {
        const own = found.slopes[j] * this.slopes[j];
        const response = responses.values[block + j * LANES];
        for (let k = 0; k < codes; k++) {
          const weight = entry.weight[j * entry.inputs + k];
          result[place + 1 + k] += own * (weight + response * weights.scale[j * codes + k]);
        }
      }
    }
    return { rest: values, slopes: result };
  }
}
