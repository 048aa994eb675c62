/** Archives of files that are not compressed (.ZIP File Format Specification, PKWARE, 6.3.10). */

/** 1 January 1980, the first day that the format knows: archives of equal files are equal. */
const DATE = 0x21;

const VERSION = 20;
const UTF8 = 0x800;

/** The bytes of an archive; files: names and contents. */
export function zipFile(files: Record<string, Uint8Array>): Uint8Array<ArrayBuffer> {
  const local: Uint8Array[] = [];
  const central: Uint8Array[] = [];
  let offset = 0;
  for (const [name, content] of Object.entries(files)) {
    const encoded = new TextEncoder().encode(name);
    const { length } = content;
    // Version, flags, method, time, date, check sum, both sizes, and the length of the name
    const shared = [
      ...[...short(VERSION), ...short(UTF8), ...short(0), ...short(0), ...short(DATE)],
      ...[...long(crc32(content)), ...long(length), ...long(length), ...short(encoded.length)],
    ];
    const head = [...long(0x04034b50), ...shared, ...short(0), ...encoded];
    local.push(Uint8Array.from(head), content);
    const entry = [...long(0x02014b50), ...short(VERSION), ...shared, ...Array(12).fill(0)];
    central.push(Uint8Array.from([...entry, ...long(offset), ...encoded]));
    offset += head.length + length;
  }
  const size = central.reduce((sum, { length }) => sum + length, 0);
  const count = short(central.length);
  const end = [...long(0x06054b50), ...Array(4).fill(0), ...count, ...count];
  return joined([
    ...local,
    ...central,
    Uint8Array.from([...end, ...long(size), ...long(offset), ...short(0)]),
  ]);
}

function joined(parts: Uint8Array[]): Uint8Array<ArrayBuffer> {
  const bytes = new Uint8Array(parts.reduce((sum, { length }) => sum + length, 0));
  let at = 0;
  for (const part of parts) {
    bytes.set(part, at);
    at += part.length;
  }
  return bytes;
}

function short(value: number): number[] {
  return [value & 0xff, value >>> 8];
}

function long(value: number): number[] {
  return [...short(value & 0xffff), ...short(value >>> 16)];
}

/** Sums of single bytes. */
const SUMS = Uint32Array.from({ length: 256 }, (_, byte) => {
  let sum = byte;
  for (let bit = 0; bit < 8; bit++) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
  return sum;
});

/** CRC-32 (ISO 3309) of bytes, in [0, 2^32). */
export function crc32(bytes: Uint8Array): number {
  let sum = 0xffffffff;
  for (const byte of bytes) sum = (sum >>> 8) ^ SUMS[(sum ^ byte) & 0xff]!;
  return (sum ^ 0xffffffff) >>> 0;
}
