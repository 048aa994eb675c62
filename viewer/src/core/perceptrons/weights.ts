/** The parameters of decoder and encoder from a weights file. */

import { FEATURES } from "../formulas";
import { type Architecture, first, type Layer, readLayers, tensorOf, transposed } from "../layers";
import type { Tensor } from "../safetensors";

export interface PerceptronWeights {
  readonly arch: Architecture;
  readonly encoder: readonly Layer[];
  readonly decoder: readonly Layer[];
  /** (neurons, codes): how a code scales the responses of the decoder's first layer. */
  readonly scale: Float64Array;
  /** Statistics (probes) that normalise the encoder's input. */
  readonly inputMean: Float64Array;
  readonly inputScale: Float64Array;
}

export function readPerceptrons(
  tensors: ReadonlyMap<string, Tensor>,
  arch: Architecture,
): PerceptronWeights {
  const { rest, probes } = arch;
  const inputs = rest - 1 + FEATURES.DIRECTION_FEATURES[2];
  const decoder = readLayers(tensors, "decoder", inputs, 1);
  return {
    arch,
    decoder,
    encoder: readLayers(tensors, "encoder", probes, rest),
    scale: transposed(tensorOf(tensors, "decoder.scale", [rest - 1, first(decoder).outputs])),
    inputMean: tensorOf(tensors, "encoder.input_mean", [probes]).values,
    inputScale: tensorOf(tensors, "encoder.input_scale", [probes]).values,
  };
}
