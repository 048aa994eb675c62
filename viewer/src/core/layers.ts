/** Layers of networks, and sizes, as weights files have them. */

import type { Widths } from "./features";
import { FileError, type Tensor } from "./safetensors";

/** Sizes of codes and networks; see Python's `nets.linear`. */
export interface Architecture {
  /** Numbers of one channel's code. */
  readonly latent: number;
  /** GGX widths of a surface. */
  readonly widths: Widths;
  /** Numbers of a code that describe its lobe. */
  readonly lobe: number;
  /** Numbers of the rest, which follow those of the lobe and begin with a gain. */
  readonly rest: number;
  /** Number of probe pairs. */
  readonly probes: number;
  readonly activation: string;
  /** Pairs of the first crossing, from which the layerer begins; 0: it begins from the bottom. */
  readonly crossing: number;
}

/** One layer: weight (outputs, inputs) by rows, transposed from the file, and bias. */
export interface Layer {
  readonly inputs: number;
  readonly outputs: number;
  readonly weight: Float64Array;
  readonly bias: Float64Array;
}

export function readLayers(
  tensors: ReadonlyMap<string, Tensor>,
  part: string,
  inputs: number,
  outputs: number,
): Layer[] {
  const layers: Layer[] = [];
  let width = inputs;
  for (let index = 0; tensors.has(`${part}.${index}.weight`); index++) {
    const bias = tensors.get(`${part}.${index}.bias`);
    const next = bias?.shape[0] ?? 0;
    const weight = tensorOf(tensors, `${part}.${index}.weight`, [width, next]);
    const values = tensorOf(tensors, `${part}.${index}.bias`, [next]).values;
    layers.push({ inputs: width, outputs: next, weight: transposed(weight), bias: values });
    width = next;
  }
  if (layers.length < 2 || width !== outputs) {
    throw new FileError(`the ${part} has ${layers.length} layers and gives ${width} numbers`);
  }
  return layers;
}

/** The first of a list that is not empty. */
export function first<T>(list: readonly T[]): T {
  return list[0] as T;
}

/** The last of a list that is not empty. */
export function last<T>(list: readonly T[]): T {
  return list[list.length - 1] as T;
}

export function tensorOf(
  tensors: ReadonlyMap<string, Tensor>,
  name: string,
  shape: readonly number[],
): Tensor {
  const tensor = tensors.get(name);
  if (!tensor || tensor.shape.join() !== shape.join()) {
    const found = tensor ? `has the shape (${tensor.shape.join(", ")})` : "is missing";
    throw new FileError(`the parameter '${name}' ${found}; this page needs (${shape.join(", ")})`);
  }
  if (!tensor.values.every(Number.isFinite)) {
    throw new FileError(`the parameter '${name}' holds a number that is not finite`);
  }
  return tensor;
}

export function transposed(tensor: Tensor): Float64Array {
  const [rows = 0, columns = 0] = tensor.shape;
  const result = new Float64Array(rows * columns);
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      result[j * rows + i] = tensor.values[i * columns + j] as number;
    }
  }
  return result;
}
