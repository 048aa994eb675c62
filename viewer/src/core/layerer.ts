/** The layerer: from the code of a bottom and a coat to the code of the coated BRDF. */

import { COAT_FEATURES, type CoatOfChannel, coatFeatures } from "./features";
import { LOBE_FEATURES, lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";
import type { Weights } from "./weights";

export class Layerer {
  private readonly network: Mlp;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.layerer, activation);
  }

  /** The codes of bottoms under coats, the same number of both. */
  layer(bottoms: readonly Float32Array[], coats: readonly CoatOfChannel[]): Float32Array[] {
    const { rest, lobe, widths } = this.weights.arch;
    const ofLobe = LOBE_FEATURES[widths];
    const width = rest + ofLobe + COAT_FEATURES[widths];
    const inputs = new Float64Array(bottoms.length * width);
    bottoms.forEach((bottom, row) => {
      const at = row * width;
      inputs.set(bottom.subarray(lobe), at);
      lobeFeatures(bottom, 0, inputs, at + rest, widths);
      coatFeatures(coats[row], inputs, at + rest + ofLobe, widths);
    });
    const changes = this.network.evaluate(inputs, bottoms.length);
    return bottoms.map((bottom, row) => {
      const code = bottom.slice();
      const across = widths === 2 ? [coats[row].alphaV] : [];
      code.set([coats[row].alpha, 0, 0, 1, coats[row].eta, 0, ...across]);
      for (let k = 0; k < rest; k++) {
        code[lobe + k] = bottom[lobe + k] + changes[row * rest + k];
      }
      return code;
    });
  }
}
