/** The layerer: from the code of a bottom and a coat to the code of the coated BRDF. */

import { COAT_FEATURES, type CoatOfChannel, coatFeatures } from "./features";
import { LOBE_FEATURES, lobeFeatures } from "./lobe";
import { type Activation, Mlp } from "./mlp";
import { asLobe, finish, underCoat } from "./second_lobe";
import { LEADING, LOBE_NUMBERS, type Weights } from "./weights";

/** How fast a coat's change grows with its index and with its optical depth. */
const CHANGE = 0.02;
const DEPTH = 0.125;

export class Layerer {
  private readonly network: Mlp;
  private readonly ofBottom: number;

  constructor(
    private readonly weights: Weights,
    activation: Activation,
  ) {
    this.network = new Mlp(weights.layerer, activation);
    this.ofBottom = bottomInputCount(weights.arch.codes);
  }

  /** The codes of bottoms under coats, the same number of both. */
  layer(bottoms: readonly Float32Array[], coats: readonly CoatOfChannel[]): Float32Array[] {
    const { arch } = this.weights;
    const width = this.ofBottom + COAT_FEATURES;
    const inputs = new Float64Array(bottoms.length * width);
    bottoms.forEach((bottom, row) => {
      bottomInputs(bottom, arch.codes, inputs, row * width);
      coatFeatures(coats[row], inputs, row * width + this.ofBottom);
    });
    const changes = this.network.evaluate(inputs, bottoms.length);
    return bottoms.map((bottom, row) => {
      const coat = coats[row];
      const code = Float64Array.from(bottom);
      underCoat(bottom, LOBE_NUMBERS, coat, code, LOBE_NUMBERS + 1);
      code.set([coat.alpha, 0, 0, 1, coat.eta, 0]);
      const present = presence(coat);
      for (let k = 0; k < arch.rest; k++) {
        code[LOBE_NUMBERS + k] += present * changes[row * arch.rest + k];
      }
      finish(code, LOBE_NUMBERS + 1);
      return Float32Array.from(code);
    });
  }
}

/** How much of a change a coat can make: 0 without interface and medium, up to 1. */
function presence(coat: CoatOfChannel): number {
  const change = (coat.eta - 1) / (coat.eta + 1) / CHANGE;
  return 1 - Math.exp(-(change * change) - coat.sigmaT / DEPTH);
}

/** Number of a code's inputs to layerer and sampler. */
export function bottomInputCount(codes: number): number {
  return 1 + codes + 2 * LOBE_FEATURES;
}

/** Put what layerer and sampler see of a code into `out`: gain, codes, features of both lobes. */
export function bottomInputs(
  code: ArrayLike<number>,
  codes: number,
  out: Float64Array,
  at: number,
): void {
  out[at] = code[LOBE_NUMBERS];
  for (let k = 0; k < codes; k++) {
    out[at + 1 + k] = code[LOBE_NUMBERS + LEADING + k];
  }
  const place = at + 1 + codes;
  lobeFeatures(code, 0, out, place);
  lobeFeatures(asLobe(code, LOBE_NUMBERS + 1), 0, out, place + LOBE_FEATURES);
}
