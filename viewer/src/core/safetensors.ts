/** Reading of safetensors files: named arrays, and Urushi's JSON description of them. */

import { Refusal } from "../refusal";

/** An array of a file, as double precision numbers. */
export interface Tensor {
  readonly shape: readonly number[];
  readonly values: Float64Array;
}

/** What a file holds. */
export interface TensorFile {
  /** The JSON object that Urushi writes into the metadata; empty in foreign files. */
  readonly description: Readonly<Record<string, unknown>>;
  readonly tensors: ReadonlyMap<string, Tensor>;
}

/** A file that is damaged or of another kind. Its message is one sentence. */
export class FileError extends Refusal {
  // Written out, because minified classes have other names, and workers send names.
  override readonly name = "FileError";
}

/** The only metadata key. */
const METADATA_KEY = "urushi";

/** Headers of sane files are far smaller. */
const LARGEST_HEADER = 1 << 24;

const READERS: Readonly<Record<string, { bytes: number; read: Reader }>> = {
  F16: { bytes: 2, read: (view, at) => halfPrecision(view.getUint16(at, true)) },
  F32: { bytes: 4, read: (view, at) => view.getFloat32(at, true) },
  F64: { bytes: 8, read: (view, at) => view.getFloat64(at, true) },
};

type Reader = (view: DataView, at: number) => number;

/**
 * Read a file of half, single or double precision arrays.
 *
 * @throws FileError if it is truncated, no safetensors file, or has arrays of other types.
 */
export function readTensors(file: ArrayBuffer): TensorFile {
  const header = readHeader(file);
  const start = 8 + header.bytes;
  const tensors = new Map<string, Tensor>();
  for (const [name, entry] of Object.entries(header.entries)) {
    if (name !== "__metadata__") {
      tensors.set(name, readTensor(new DataView(file, start), name, entry));
    }
  }
  return { description: descriptionOf(header.entries), tensors };
}

function readHeader(file: ArrayBuffer): { bytes: number; entries: Record<string, unknown> } {
  const view = new DataView(file);
  const bytes = file.byteLength < 8 ? Number.NaN : Number(view.getBigUint64(0, true));
  if (!(bytes <= Math.min(file.byteLength - 8, LARGEST_HEADER))) {
    throw new FileError(`the file (${file.byteLength} bytes) is no safetensors file, or truncated`);
  }
  const text = new TextDecoder().decode(new Uint8Array(file, 8, bytes));
  const entries = parsed(text);
  if (!isRecord(entries)) {
    throw new FileError("the file's header is no JSON object; copy or create the file again");
  }
  return { bytes, entries };
}

function descriptionOf(entries: Record<string, unknown>): Record<string, unknown> {
  const metadata = entries.__metadata__;
  const text = isRecord(metadata) ? metadata[METADATA_KEY] : undefined;
  const description = typeof text === "string" ? parsed(text) : undefined;
  return isRecord(description) ? description : {};
}

function readTensor(data: DataView, name: string, entry: unknown): Tensor {
  const { dtype, shape, data_offsets: offsets } = isRecord(entry) ? entry : {};
  const reader = typeof dtype === "string" ? READERS[dtype] : undefined;
  if (!reader) {
    throw new FileError(`the array '${name}' is of type ${String(dtype)}; give F16, F32 or F64`);
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

/** The number of sixteen bits (IEEE 754). */
function halfPrecision(bits: number): number {
  const sign = bits & 0x8000 ? -1 : 1;
  const exponent = (bits >> 10) & 0x1f;
  const fraction = bits & 0x3ff;
  if (exponent === 0) {
    return sign * fraction * 2 ** -24;
  }
  if (exponent === 0x1f) {
    return fraction ? Number.NaN : sign * Number.POSITIVE_INFINITY;
  }
  return sign * (1 + fraction / 1024) * 2 ** (exponent - 15);
}

function parsed(text: string): unknown {
  try {
    return JSON.parse(text);
  } catch {
    return undefined;
  }
}

/** Whether a value is a JSON object. */
export function isRecord(value: unknown): value is Record<string, unknown> {
  return typeof value === "object" && value !== null && !Array.isArray(value);
}

function isCounts(value: unknown): value is number[] {
  return Array.isArray(value) && value.every((size) => Number.isSafeInteger(size) && size >= 0);
}
