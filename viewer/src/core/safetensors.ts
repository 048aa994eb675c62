/** Safetensors files: named arrays, and Urushi's JSON description of them. */

import { Refusal } from "../refusal";
import { fromHalf } from "./half";

/** A file that is damaged or of another kind. Its message is one sentence. */
export class FileError extends Refusal {
  // Written out, because minified classes have other names, and workers send names.
  override readonly name = "FileError";
}

export type Fields = Record<string, unknown>;

/** The only metadata key. */
const METADATA_KEY = "urushi";

/** Types of numbers: of bytes, and of half, single and double precision. Files are little-endian. */
const TYPES = {
  U8: Uint8Array,
  U16: Uint16Array,
  F16: Uint16Array, // its bits
  F32: Float32Array,
  F64: Float64Array,
};

type Type = keyof typeof TYPES;

/** A file, whose arrays are read when they are asked for. */
export class TensorFile {
  /** The JSON object that Urushi writes into the metadata; empty in foreign files. */
  readonly description: Fields;
  private readonly entries: Fields;
  private readonly data: Uint8Array;

  /** @throws FileError if it is truncated or no safetensors file. */
  constructor(file: Uint8Array) {
    try {
      const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
      const start = 8 + Number(view.getBigUint64(0, true));
      const head = JSON.parse(new TextDecoder().decode(file.slice(8, start)));
      const { __metadata__: metadata, ...entries } = head;
      this.description = Object(JSON.parse(metadata?.[METADATA_KEY] ?? "{}"));
      this.entries = entries;
      this.data = file.subarray(start);
    } catch {
      throw new FileError(`The file (${file.length} bytes) is no safetensors file, or truncated.`);
    }
  }

  /** The shape of an array; empty if there is none. */
  shapeOf(name: string): readonly number[] {
    const { shape } = Object(this.entries[name]) as Fields;
    return isCounts(shape) ? shape : [];
  }

  /**
   * The bytes of an array of a type and a shape.
   *
   * @throws FileError if it is missing, of another type or shape, or not in the file as a whole.
   */
  bytes(name: string, type: Type, shape: readonly number[]): Uint8Array<ArrayBuffer> {
    const own = this.shapeOf(name);
    const { dtype, data_offsets: offsets } = Object(this.entries[name]) as Fields;
    if (own.join() !== shape.join() || dtype !== type) {
      const found = dtype ? `has the shape (${own.join(", ")}) and type ${dtype}` : "is missing";
      const wanted = `(${shape.join(", ")}) and ${type}`;
      throw new FileError(`The array '${name}' ${found}; this page needs ${wanted}.`);
    }
    const [first = 0, end = -1] = isCounts(offsets) ? offsets : [];
    const size = shape.reduce((product, x) => product * x, TYPES[type].BYTES_PER_ELEMENT);
    if (end !== first + size || end > this.data.length)
      throw new FileError(`The array '${name}' does not fit the file; copy or create it again.`);
    return this.data.slice(first, end) as Uint8Array<ArrayBuffer>;
  }

  /** The numbers of an array of a shape and any type, all finite. @throws FileError */
  numbers(name: string, shape: readonly number[]): Float64Array {
    const { dtype } = Object(this.entries[name]) as { dtype?: string };
    const type = dtype && dtype in TYPES ? (dtype as Type) : "F32";
    const raw = new TYPES[type](this.bytes(name, type, shape).buffer);
    const values = type === "F16" ? Float64Array.from(raw, fromHalf) : Float64Array.from(raw);
    if (!values.every(Number.isFinite))
      throw new FileError(`The array '${name}' holds a number that is not finite.`);
    return values;
  }
}

/** An array to be written. */
export interface Tensor {
  dtype: Type;
  shape: readonly number[];
  bytes: Uint8Array;
}

/** The bytes of a file. */
export function tensorFile(
  description: Fields,
  arrays: Record<string, Tensor>,
): Uint8Array<ArrayBuffer> {
  let end = 0;
  const entries = Object.entries(arrays).map(([name, { dtype, shape, bytes }]) => {
    const first = end;
    end += bytes.length;
    return [name, { dtype, shape, data_offsets: [first, end] }] as const;
  });
  const metadata = { [METADATA_KEY]: JSON.stringify(description) };
  const json = JSON.stringify({ __metadata__: metadata, ...Object.fromEntries(entries) });
  // Numbers begin at a multiple of eight bytes.
  const text = new TextEncoder().encode(json);
  const start = 8 + Math.ceil(text.length / 8) * 8;
  const file = new Uint8Array(start + end).fill(0x20, 8, start);
  new DataView(file.buffer).setBigUint64(0, BigInt(start - 8), true);
  file.set(text, 8);
  Object.values(arrays).forEach(({ bytes }, k) => {
    file.set(bytes, start + entries[k][1].data_offsets[0]);
  });
  return file;
}

function isCounts(value: unknown): value is number[] {
  return Array.isArray(value) && value.every((size) => Number.isSafeInteger(size) && size >= 0);
}
