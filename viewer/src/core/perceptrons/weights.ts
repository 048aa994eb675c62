/** The parameters of decoder and encoder from a weights file. */

import { FEATURES, LOBE } from "../formulas";
import { type Architecture, first, type Layer, readLayers, tensorOf, transposed } from "../layers";
import type { Tensor } from "../safetensors";

export interface PerceptronWeights {
  readonly arch: Architecture;
  readonly encoder: readonly Layer[];
  readonly decoder: readonly Layer[];
  readonly sampler: readonly Layer[];
  /** Lobes of the proposal beside the code's own. */
  readonly lobes: number;
  /** (neurons, codes): how a code scales the responses of the decoder's first layer. */
  readonly scale: Float64Array;
  /** Statistics (probes) that normalise the encoder's input. */
  readonly inputMean: Float64Array;
  readonly inputScale: Float64Array;
}

export function readPerceptrons(
  tensors: ReadonlyMap<string, Tensor>,
  arch: Architecture,
  lobes: number,
): PerceptronWeights {
  const { rest, probes } = arch;
  const ofSampler = LOBE.LOBE_FEATURES[2] + rest + 4;
  const inputs = rest - 1 + FEATURES.DIRECTION_FEATURES[2];
  const decoder = readLayers(tensors, "decoder", inputs, 1);
  return {
    arch,
    decoder,
    sampler: readLayers(tensors, "sampler", ofSampler, 3 * lobes + 2),
    lobes,
    encoder: readLayers(tensors, "encoder", probes, rest),
    scale: transposed(tensorOf(tensors, "decoder.scale", [rest - 1, first(decoder).outputs])),
    inputMean: tensorOf(tensors, "encoder.input_mean", [probes]).values,
    inputScale: tensorOf(tensors, "encoder.input_scale", [probes]).values,
  };
}
