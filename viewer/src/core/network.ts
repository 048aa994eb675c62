/** Multilayer perceptrons and their activation; see Python's `nets.mlp`. */

import { MLP } from "../printed/formulas";
import { FileError, type TensorFile } from "./safetensors";

export class Network {
  /** Weights (inputs, outputs) and bias of each layer. */
  private readonly layers: (readonly [weight: Float64Array, bias: Float64Array])[] = [];
  private readonly bound: number;
  private readonly q: readonly number[];

  /**
   * @param part of the file, which begins the names of its arrays.
   * @throws FileError if they do not fit, or the activation is unknown.
   */
  constructor(file: TensorFile, part: string, inputs: number, outputs: number, activation: string) {
    if (!Object.hasOwn(MLP.POLYNOMIALS, activation))
      throw new FileError(`The networks' activation '${activation}' is unknown here.`);
    const [bound, q] = MLP.POLYNOMIALS[activation as keyof typeof MLP.POLYNOMIALS];
    this.bound = bound;
    this.q = [...q, 0, 0];
    let width = inputs;
    for (let k = 0; ; k++) {
      const [next] = file.shapeOf(`${part}.${k}.bias`);
      if (next === undefined) break;
      const weight = file.numbers(`${part}.${k}.weight`, [width, next]);
      this.layers.push([weight, file.numbers(`${part}.${k}.bias`, [next])]);
      width = next;
    }
    if (this.layers.length < 2 || width !== outputs)
      throw new FileError(
        `The ${part} has ${this.layers.length} layers and gives ${width} numbers.`,
      );
  }

  /** The outputs of one input. */
  evaluate(x: Float64Array): Float64Array {
    return this.layers.reduce((input, [weight, bias], k) => {
      const output = bias.slice();
      const width = output.length;
      input.forEach((number, i) => {
        for (let j = 0, at = i * width; j < width; j++, at++) output[j] += number * weight[at];
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
