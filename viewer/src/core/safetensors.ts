/** Reading of safetensors files: named arrays, and Urushi's JSON description of them. */

import { Refusal } from "../refusal";
import { fromHalf } from "./half";

/** An array of a file, as double precision numbers. */
export interface Tensor {
  readonly shape: readonly number[];
  readonly values: Float64Array;
}

export type Tensors = ReadonlyMap<string, Tensor>;

/** What a file holds. */
export interface TensorFile {
  /** The JSON object that Urushi writes into the metadata; empty in foreign files. */
  readonly description: Readonly<Record<string, unknown>>;
  readonly tensors: Tensors;
}

/** A file that is damaged or of another kind. Its message is one sentence. */
export class FileError extends Refusal {
  // Written out, because minified classes have other names, and workers send names.
  override readonly name = "FileError";
}

/** The only metadata key. */
const METADATA_KEY = "urushi";

const READERS: Readonly<Record<string, { bytes: number; read: Reader }>> = {
  U8: { bytes: 1, read: (view, at) => view.getUint8(at) },
  U16: { bytes: 2, read: (view, at) => view.getUint16(at, true) },
  F16: { bytes: 2, read: (view, at) => fromHalf(view.getUint16(at, true)) },
  F32: { bytes: 4, read: (view, at) => view.getFloat32(at, true) },
  F64: { bytes: 8, read: (view, at) => view.getFloat64(at, true) },
};

type Reader = (view: DataView, at: number) => number;

export type Fields = Record<string, unknown>;

/** What the head of a file says of an array, unchecked. */
export interface Entry {
  dtype: string;
  shape: number[];
  data_offsets: [number, number];
}

/** What the head says, and where the numbers begin; null: it is no safetensors file. */
export function headerOf(
  file: Uint8Array,
): { description: Fields; tensors: Record<string, Entry | undefined>; start: number } | null {
  if (file.length < 8) return null;
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const length = Number(view.getBigUint64(0, true));
  if (length === 0 || 8 + length > file.length) return null;
  try {
    const head = JSON.parse(new TextDecoder().decode(file.subarray(8, 8 + length)));
    const { __metadata__: metadata, ...tensors } = head;
    const description = Object(JSON.parse(metadata?.[METADATA_KEY] ?? "{}")) as Fields;
    return { description, tensors, start: 8 + length };
  } catch {
    return null;
  }
}

/**
 * Read a file of arrays of one or two bytes, or of half, single or double precision.
 *
 * @throws FileError if it is truncated, no safetensors file, or has arrays of other types.
 */
export function readTensors(file: ArrayBuffer): TensorFile {
  const header = headerOf(new Uint8Array(file));
  if (header === null)
    throw new FileError(`the file (${file.byteLength} bytes) is no safetensors file, or truncated`);
  const { description, tensors, start } = header;
  const data = new DataView(file, start);
  const arrays = Object.entries(tensors).map(
    ([name, entry]) => [name, readTensor(data, name, entry)] as const,
  );
  return { description, tensors: new Map(arrays) };
}

function readTensor(data: DataView, name: string, entry: unknown): Tensor {
  const { dtype, shape, data_offsets: offsets } = isRecord(entry) ? entry : {};
  const reader = typeof dtype === "string" ? READERS[dtype] : undefined;
  if (!reader) {
    throw new FileError(
      `the array '${name}' is of type ${String(dtype)}; give U8, U16, F16, F32 or F64`,
    );
  }
  if (!isCounts(shape) || !isCounts(offsets)) {
    throw new FileError(`the array '${name}' has no valid shape and place in the file`);
  }
  const count = shape.reduce((product, size) => product * size, 1);
  const [first, end] = offsets;
  if (first === undefined || end !== first + count * reader.bytes || end > data.byteLength) {
    throw new FileError(`the array '${name}' does not fit the file; copy or create it again`);
  }
  const values = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    values[i] = reader.read(data, first + i * reader.bytes);
  }
  return { shape, values };
}

/** An array of a file of a shape, whose numbers are finite. */
export function tensorOf(tensors: Tensors, name: string, shape: readonly number[]): Tensor {
  const tensor = tensors.get(name);
  if (!tensor || tensor.shape.join() !== shape.join()) {
    const found = tensor ? `has the shape (${tensor.shape.join(", ")})` : "is missing";
    throw new FileError(`the parameter '${name}' ${found}; this page needs (${shape.join(", ")})`);
  }
  if (!tensor.values.every(Number.isFinite))
    throw new FileError(`the parameter '${name}' holds a number that is not finite`);
  return tensor;
}

/** Whether a value is a JSON object. */
export function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isCounts(value: unknown): value is number[] {
  return Array.isArray(value) && value.every((size) => Number.isSafeInteger(size) && size >= 0);
}
