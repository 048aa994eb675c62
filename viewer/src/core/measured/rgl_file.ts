/** The file format of the RGL database: named arrays; see Python's `measured.rgl_file`. */

import { FileError } from "../safetensors";

const MAGIC = "tensor_file\0";

/** Limits; files of the database have 11 fields of up to 5 dimensions. */
const MOST_FIELDS = 256;
const MOST_DIMENSIONS = 16;

/** Bytes of a number by its type's code in the file. */
const SIZES: Readonly<Record<number, bigint>> = {
  1: 1n,
  2: 1n,
  3: 2n,
  4: 2n,
  5: 4n,
  6: 4n,
  7: 8n,
  8: 8n,
  9: 2n,
  10: 4n,
  11: 8n,
};

/** An array of bytes or of single precision numbers; other types have no values. */
export interface Field {
  readonly type: "u1" | "f4" | "other";
  readonly shape: readonly number[];
  readonly values: Uint8Array | Float32Array;
}

interface Place {
  readonly name: string;
  readonly code: number;
  readonly shape: readonly bigint[];
  readonly start: bigint;
  readonly end: bigint;
}

/** Whether a file begins as a tensor file. */
export function isTensorFile(file: ArrayBuffer): boolean {
  return new TextDecoder().decode(file.slice(0, MAGIC.length)) === MAGIC;
}

/**
 * The arrays of a tensor file by name.
 *
 * Sizes are checked against that of the file before memory is taken.
 *
 * @throws FileError if it is truncated, of another version, or its arrays overlap or lie outside.
 */
export function readTensorFile(file: ArrayBuffer): ReadonlyMap<string, Field> {
  const reader = new Reader(file);
  reader.take(MAGIC.length);
  const version = [reader.number(1), reader.number(1)];
  if (version.join(".") !== "1.0") {
    throw new FileError(
      `The tensor file has version ${version.join(".")}; only 1.0 can be read here.`,
    );
  }
  const count = reader.number(4);
  if (count > MOST_FIELDS) throw damaged(`it claims ${count} fields`);
  const places = Array.from({ length: count }, () => readPlace(reader));
  checkPlaces(places, BigInt(reader.at), BigInt(file.byteLength));
  return new Map(places.map((place) => [place.name, fieldOf(file, place)]));
}

class Reader {
  at = 0;

  constructor(private readonly file: ArrayBuffer) {}

  take(count: number): DataView {
    if (this.at + count > this.file.byteLength) throw damaged("its header is truncated");
    const view = new DataView(this.file, this.at, count);
    this.at += count;
    return view;
  }

  number(bytes: 1 | 2 | 4): number {
    const view = this.take(bytes);
    if (bytes === 1) return view.getUint8(0);
    return bytes === 2 ? view.getUint16(0, true) : view.getUint32(0, true);
  }

  large(): bigint {
    return this.take(8).getBigUint64(0, true);
  }
}

function readPlace(reader: Reader): Place {
  const name = new TextDecoder().decode(reader.take(reader.number(2))).slice(0, 40);
  const dimensions = reader.number(2);
  const code = reader.number(1);
  const size = SIZES[code];
  if (size === undefined) throw damaged(`its tensor '${name}' has the unknown type ${code}`);
  if (dimensions > MOST_DIMENSIONS)
    throw damaged(`its tensor '${name}' claims ${dimensions} dimensions`);
  const start = reader.large();
  const shape = Array.from({ length: dimensions }, () => reader.large());
  return { name, code, shape, start, end: start + shape.reduce((a, b) => a * b, size) };
}

function checkPlaces(places: readonly Place[], header: bigint, size: bigint): void {
  if (new Set(places.map(({ name }) => name)).size < places.length)
    throw damaged("it names a tensor twice");
  let end = header;
  for (const place of [...places].sort((a, b) => Number(a.start - b.start || a.end - b.end))) {
    if (place.end > size) throw damaged(`its tensor '${place.name}' lies outside of the file`);
    if (place.start < end) throw damaged(`its tensor '${place.name}' overlaps another`);
    end = place.end;
  }
}

function fieldOf(file: ArrayBuffer, { code, shape, start, end }: Place): Field {
  const sizes = shape.map(Number);
  const bytes = file.slice(Number(start), Number(end));
  if (code === 1) return { type: "u1", shape: sizes, values: new Uint8Array(bytes) };
  if (code === 10) return { type: "f4", shape: sizes, values: new Float32Array(bytes) };
  return { type: "other", shape: sizes, values: new Uint8Array() };
}

function damaged(what: string): FileError {
  return new FileError(`The tensor file is damaged: ${what}; obtain it again.`);
}
