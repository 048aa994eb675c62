/** Multilayer perceptrons and their activation; see Python's `nets.mlp`. */

import { MLP } from "./formulas";
import { FileError, type Tensor, type Tensors, tensorOf } from "./safetensors";

export class Network {
  /** Weights (inputs, outputs) and bias of each layer. */
  private readonly layers: (readonly [weight: Tensor, bias: Tensor])[] = [];
  private readonly bound: number;
  private readonly q: readonly number[];

  /**
   * @param part of the file, which begins the names of its arrays.
   * @throws FileError if they do not fit, or the activation is unknown.
   */
  constructor(tensors: Tensors, part: string, inputs: number, outputs: number, activation: string) {
    if (!Object.hasOwn(MLP.POLYNOMIALS, activation))
      throw new FileError(`the networks' activation '${activation}' is unknown here`);
    const [bound, q] = MLP.POLYNOMIALS[activation as keyof typeof MLP.POLYNOMIALS];
    this.bound = bound;
    this.q = [...q, 0, 0];
    let width = inputs;
    for (let k = 0; tensors.has(`${part}.${k}.weight`); k++) {
      const next = tensors.get(`${part}.${k}.bias`)?.shape[0] ?? 0;
      const weight = tensorOf(tensors, `${part}.${k}.weight`, [width, next]);
      this.layers.push([weight, tensorOf(tensors, `${part}.${k}.bias`, [next])]);
      width = next;
    }
    if (this.layers.length < 2 || width !== outputs)
      throw new FileError(
        `the ${part} has ${this.layers.length} layers and gives ${width} numbers`,
      );
  }

  /** The outputs of one input. */
  evaluate(x: Float64Array): Float64Array {
    return this.layers.reduce((input, [weight, bias], k) => {
      const output = bias.values.slice();
      const width = output.length;
      input.forEach((number, i) => {
        for (let j = 0, at = i * width; j < width; j++, at++)
          output[j] += number * weight.values[at];
      });
      return k < this.layers.length - 1 ? output.map(this.activate) : output;
    }, x);
  }

  private readonly activate = (value: number): number => {
    const [q0, q1, q2, q3] = this.q;
    const t = Math.min(Math.max(value, -this.bound), this.bound);
    const u = t * t;
    return value * (0.5 + t * (q0 + u * (q1 + u * (q2 + u * q3))));
  };
}
