/** The encoder: from the values of a BRDF at the probe pairs to the code of its rest. */

import type { Pairs, Widths } from "./features";
import { ENCODER } from "./formulas";
import { type Activation, Mlp } from "./mlp";
import { probePairs } from "./probe_pairs";
import type { Weights } from "./weights";

const { OFFSET } = ENCODER;

export class Encoder {
  /** The pairs at which values are needed. */
  readonly pairs: Pairs;
  private readonly network: Mlp;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.encoder, activation);
    this.pairs = probePairs(weights.arch.probes, weights.arch.widths);
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
}
