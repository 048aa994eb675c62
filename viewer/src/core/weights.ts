/** The networks' sizes and parameters from a weights file of `urushi train`. */

import type { Widths } from "./features";
import { FEATURES, LOBE } from "./formulas";
import { FileError, isRecord, readTensors, type Tensor } from "./safetensors";

/** Version of the file format. */
const FORMAT_VERSION = 1;

/** Names of parameters. */
const KNOWN =
  /^((decoder|encoder|layerer|sampler)\.\d+\.(weight|bias)|decoder\.scale|encoder\.input_(mean|scale))$/;

/** Sizes of the networks; see Python's `nets.architecture`. */
interface Architecture {
  /** Numbers of one channel's code. */
  readonly latent: number;
  /** GGX widths of a surface. */
  readonly widths: Widths;
  /** Numbers of a code that describe its lobe. */
  readonly lobe: number;
  /** Numbers of the rest, which follow those of the lobe and begin with a gain. */
  readonly rest: number;
  /** Inputs of the decoder's network: the numbers of the rest after its gain. */
  readonly codes: number;
  /** Lobes of the proposal beside the code's own. */
  readonly lobes: number;
  /** Probe pairs of the encoder. */
  readonly probes: number;
  readonly activation: string;
}

/** One layer: weight (outputs, inputs) by rows, transposed from the file, and bias. */
export interface Layer {
  readonly inputs: number;
  readonly outputs: number;
  readonly weight: Float64Array;
  readonly bias: Float64Array;
}

/** Sizes and parameters of all networks. */
export interface Weights {
  readonly arch: Architecture;
  /** Identifies the networks: materials belong to them. */
  readonly fingerprint: string;
  readonly encoder: readonly Layer[];
  readonly layerer: readonly Layer[];
  readonly decoder: readonly Layer[];
  readonly sampler: readonly Layer[];
  /** (neurons, codes): how a code scales the responses of the decoder's first layer. */
  readonly scale: Float64Array;
  /** Statistics (probes) that normalise the encoder's input. */
  readonly inputMean: Float64Array;
  readonly inputScale: Float64Array;
}

/**
 * Read a weights file.
 *
 * @throws FileError if it is damaged, or of networks that this core does not know.
 */
export function readWeights(file: ArrayBuffer): Weights {
  const { description, tensors } = readTensors(file);
  if (description.kind !== "weights" || description.version !== FORMAT_VERSION) {
    throw new FileError("the file holds no weights of Urushi's networks in a version known here");
  }
  const arch = readArchitecture(description.architecture);
  const unknown = [...tensors.keys()].find((name) => !KNOWN.test(name));
  if (unknown) {
    throw new FileError(
      `the parameter '${unknown}' is unknown here; the networks are of another kind`,
    );
  }
  const part = (name: string, inputs: number, outputs: number) =>
    readLayers(tensors, name, inputs, outputs);
  const { widths, rest } = arch;
  const decoder = part("decoder", arch.codes + FEATURES.DIRECTION_FEATURES[widths], 1);
  const ofLobe = LOBE.LOBE_FEATURES[widths];
  return {
    arch,
    fingerprint: String(description.fingerprint ?? ""),
    decoder,
    encoder: part("encoder", arch.probes, rest),
    layerer: part("layerer", rest + ofLobe + FEATURES.COAT_FEATURES[widths], rest),
    sampler: part("sampler", ofLobe + rest + 2 * widths, (1 + widths) * arch.lobes + 2),
    scale: transposed(tensorOf(tensors, "decoder.scale", [arch.codes, first(decoder).outputs])),
    inputMean: tensorOf(tensors, "encoder.input_mean", [arch.probes]).values,
    inputScale: tensorOf(tensors, "encoder.input_scale", [arch.probes]).values,
  };
}

function readArchitecture(value: unknown): Architecture {
  const sizes = isRecord(value) ? value : {};
  const size = (name: string): number => {
    const found = sizes[name];
    if (typeof found !== "number" || !Number.isSafeInteger(found) || found < 1) {
      throw new FileError(`the weights' architecture has no valid size '${name}'`);
    }
    return found;
  };
  const widths = sizes.widths === undefined ? 1 : size("widths");
  if (widths !== 1 && widths !== 2) {
    throw new FileError(
      `the architecture's surfaces have ${widths} widths; this page reads 1 or 2`,
    );
  }
  const lobe = LOBE.NUMBERS[widths].length;
  if (size("lobe") !== lobe) {
    throw new FileError(`the codes' lobes have ${size("lobe")} numbers; this page reads ${lobe}`);
  }
  const latent = size("latent");
  const rest = latent - lobe;
  if (rest < 2) {
    throw new FileError(
      `the architecture's latent is ${latent}; a code has at least ${lobe + 2} numbers`,
    );
  }
  return {
    latent,
    widths,
    lobe,
    rest,
    codes: rest - 1,
    lobes: size("lobes"),
    probes: size("probes"),
    activation: String(sizes.activation),
  };
}

function readLayers(
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

function tensorOf(
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

function transposed(tensor: Tensor): Float64Array {
  const [rows = 0, columns = 0] = tensor.shape;
  const result = new Float64Array(rows * columns);
  for (let i = 0; i < rows; i++) {
    for (let j = 0; j < columns; j++) {
      result[j * rows + i] = tensor.values[i * columns + j] as number;
    }
  }
  return result;
}
