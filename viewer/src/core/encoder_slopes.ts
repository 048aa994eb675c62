/** Derivatives of the encoder's network by its inputs; see Python's `nets.derivatives`. */

import { type Activation, activateWithSlope, linear } from "./mlp";
import { first, last, type Weights } from "./weights";

/** Numbers of a code (R), and their derivatives (R, P) by the inputs ln(f + offset). */
export interface EncoderSlopes {
  readonly numbers: Float64Array;
  readonly slopes: Float64Array;
}

/** The rest of a code and its derivatives for logarithms (P) of values at the probe pairs. */
export function encoderSlopes(
  weights: Weights,
  activation: Activation,
  logs: Float64Array,
): EncoderSlopes {
  const { encoder, inputMean, inputScale } = weights;
  let state = logs.map((log, i) => (log - inputMean[i]) / inputScale[i]);
  const slopesOfStates: Float64Array[] = [];
  encoder.forEach((layer, index) => {
    const next = new Float64Array(layer.outputs);
    linear(layer, state, next, 1);
    if (index < encoder.length - 1) {
      const slopes = new Float64Array(layer.outputs);
      activateWithSlope(next, slopes, layer.outputs, activation);
      slopesOfStates.push(slopes);
    }
    state = next;
  });
  const numbers = state;
  const count = numbers.length;
  // From the outputs back: (R, inputs of a layer)
  let gradient = last(encoder).weight.slice();
  for (let index = encoder.length - 2; index >= 0; index--) {
    const { inputs, outputs, weight } = encoder[index];
    const before = new Float64Array(count * inputs);
    for (let r = 0; r < count; r++) {
      for (let j = 0; j < outputs; j++) {
        const factor = gradient[r * outputs + j] * slopesOfStates[index][j];
        for (let i = 0; i < inputs; i++) {
          before[r * inputs + i] += factor * weight[j * inputs + i];
        }
      }
    }
    gradient = before;
  }
  const inputs = first(encoder).inputs;
  return { numbers, slopes: gradient.map((value, at) => value / inputScale[at % inputs]) };
}
