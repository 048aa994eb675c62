/** Archives of files that are not compressed, and check sums. */

import { zipSync } from "three/addons/libs/fflate.module.js";

/** The bytes of an archive; files: names and contents. Archives of equal files are equal. */
export function zipFile(files: Record<string, Uint8Array>): Uint8Array<ArrayBuffer> {
  const mtime = new Date(1980, 0, 1); // the first day that the format knows
  return zipSync(files, { level: 0, mtime }) as Uint8Array<ArrayBuffer>;
}

/** Sums of single bytes. */
const SUMS = Uint32Array.from({ length: 256 }, (_, byte) => {
  let sum = byte;
  for (let bit = 0; bit < 8; bit++) sum = (sum >>> 1) ^ (sum & 1 ? 0xedb88320 : 0);
  return sum;
});

/** The check sum of bytes as eight digits, by which the state names what was opened. */
export function nameOf(bytes: Uint8Array): string {
  return crc32(bytes).toString(16).padStart(8, "0");
}

/** CRC-32 (ISO 3309) of bytes, in [0, 2^32). */
export function crc32(bytes: Uint8Array): number {
  let sum = 0xffffffff;
  for (const byte of bytes) sum = (sum >>> 8) ^ SUMS[(sum ^ byte) & 0xff];
  return (sum ^ 0xffffffff) >>> 0;
}
