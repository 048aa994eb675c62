/** Multilayer perceptrons and their activation; see Python's `nets.mlp`. */

import { MLP } from "./formulas";
import type { Layer } from "./layers";
import { FileError } from "./safetensors";

/** An activation: its bound and its polynomial, see `POLYNOMIALS` of Python's `nets.mlp`. */
export interface Activation {
  readonly bound: number;
  readonly q: readonly number[];
}

/**
 * The activation of a name.
 *
 * @throws FileError if this core does not know it.
 */
export function activationOf(name: string): Activation {
  if (!Object.hasOwn(MLP.POLYNOMIALS, name)) {
    throw new FileError(`the networks' activation '${name}' is unknown here`);
  }
  const [bound, q] = MLP.POLYNOMIALS[name as keyof typeof MLP.POLYNOMIALS];
  return { bound, q: [...q, 0, 0].slice(0, 4) };
}

/** Apply an activation to the first `count` numbers, in place. */
export function activate(x: Float64Array, count: number, activation: Activation): void {
  const { bound } = activation;
  const [q0, q1, q2, q3] = activation.q;
  for (let i = 0; i < count; i++) {
    const value = x[i];
    const t = Math.min(Math.max(value, -bound), bound);
    const u = t * t;
    x[i] = value * (0.5 + t * (q0 + u * (q1 + u * (q2 + u * q3))));
  }
}

/**
 * A network that is evaluated for several inputs at once, so that each weight is read once.
 *
 * Buffers are reused: a result is valid until the next evaluation.
 */
export class Mlp {
  private readonly buffers: Float64Array[] = [];

  constructor(
    private readonly layers: readonly Layer[],
    private readonly activation: Activation,
  ) {}

  /** Evaluate `count` inputs, one after the other in x; returns the outputs alike. */
  evaluate(x: Float64Array, count: number): Float64Array {
    let input = x;
    this.layers.forEach((layer, index) => {
      const size = count * layer.outputs;
      let output = this.buffers[index];
      if (!output || output.length < size) {
        output = new Float64Array(size);
        this.buffers[index] = output;
      }
      linear(layer, input, output, count);
      if (index < this.layers.length - 1) {
        activate(output, size, this.activation);
      }
      input = output;
    });
    return input;
  }
}

/** One layer for `count` inputs; three at a time, as a colour has three channels. */
export function linear(layer: Layer, x: Float64Array, y: Float64Array, count: number): void {
  let row = 0;
  for (; row + 3 <= count; row += 3) {
    linearOfThree(layer, x, y, row);
  }
  for (; row < count; row++) {
    linearOfOne(layer, x, y, row);
  }
}

function linearOfThree(layer: Layer, x: Float64Array, y: Float64Array, row: number): void {
  const { inputs, outputs, weight, bias } = layer;
  const first = row * inputs;
  const second = first + inputs;
  const third = second + inputs;
  for (let j = 0; j < outputs; j++) {
    let at = j * inputs;
    let a = bias[j];
    let b = a;
    let c = a;
    for (let i = 0; i < inputs; i++, at++) {
      const w = weight[at];
      a += w * x[first + i];
      b += w * x[second + i];
      c += w * x[third + i];
    }
    const place = row * outputs + j;
    y[place] = a;
    y[place + outputs] = b;
    y[place + 2 * outputs] = c;
  }
}

function linearOfOne(layer: Layer, x: Float64Array, y: Float64Array, row: number): void {
  const { inputs, outputs, weight, bias } = layer;
  const start = row * inputs;
  const whole = inputs & ~3;
  for (let j = 0; j < outputs; j++) {
    const at = j * inputs;
    let a = bias[j];
    let b = 0;
    let c = 0;
    let d = 0;
    for (let i = 0; i < whole; i += 4) {
      a += weight[at + i] * x[start + i];
      b += weight[at + i + 1] * x[start + i + 1];
      c += weight[at + i + 2] * x[start + i + 2];
      d += weight[at + i + 3] * x[start + i + 3];
    }
    for (let i = whole; i < inputs; i++) {
      a += weight[at + i] * x[start + i];
    }
    y[row * outputs + j] = a + b + (c + d);
  }
}
