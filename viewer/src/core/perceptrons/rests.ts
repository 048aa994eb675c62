/** Rests by the decoder and the encoder of two GGX widths, until a basis replaces them. */

import type { Pairs } from "../features";
import { ENCODER } from "../formulas";
import { lobeValues } from "../lobe";
import { type Activation, Mlp } from "../mlp";
import { probePairs } from "../probe_pairs";
import { type AtPairs, difference, type Rests } from "../rests";
import { Decoder } from "./decoder";
import type { PerceptronWeights } from "./weights";

export class PerceptronRests implements Rests {
  readonly widths = 2;
  readonly probes: Pairs;
  private readonly decoder: Decoder;
  private readonly encoder: Mlp;

  constructor(
    private readonly weights: PerceptronWeights,
    activation: Activation,
  ) {
    this.probes = probePairs(weights.inputMean.length, 2);
    this.decoder = new Decoder(weights, activation);
    this.encoder = new Mlp(weights.encoder, activation);
  }

  at(pairs: Pairs, count = pairs.capacity): AtPairs {
    return this.decoder.respond(pairs, count);
  }

  values(code: Float32Array, at: AtPairs): Float64Array {
    return this.decoder.rest(this.decoder.prepare(code, this.weights.arch.lobe), at);
  }

  encode(lobe: Float32Array, f: Float64Array): Float32Array {
    const { inputMean, inputScale } = this.weights;
    const rest = difference(f, lobeValues(lobe, this.probes));
    const inputs = rest.map(
      (value, i) => (Math.log(value + ENCODER.OFFSET) - inputMean[i]) / inputScale[i],
    );
    const numbers = this.encoder.evaluate(inputs, 1).subarray(0, this.weights.arch.rest);
    return Float32Array.of(...lobe, ...numbers);
  }

  without(lobe: Float32Array): Float32Array {
    return this.encode(lobe, lobeValues(lobe, this.probes));
  }
}
