/** The codes of a material's channels. */

/** Number of channels of every material. */
export const CHANNELS = 3;

/** The codes (L) of all channels, which share the memory of codes (3, L). */
export function rows(codes: Float32Array, size: number): Float32Array[] {
  return Array.from({ length: CHANNELS }, (_, row) => codes.subarray(row * size, (row + 1) * size));
}

/** Codes (3, L) of those of the channels. */
export function joined(codes: readonly Float32Array[]): Float32Array {
  const result = new Float32Array(codes.reduce((length, code) => length + code.length, 0));
  let at = 0;
  for (const code of codes) {
    result.set(code, at);
    at += code.length;
  }
  return result;
}

/** The first channel that is the same as the given one. */
export function firstSame(channel: number, isSame: (a: number, b: number) => boolean): number {
  for (let other = 0; other < channel; other++) {
    if (isSame(other, channel)) {
      return other;
    }
  }
  return channel;
}

/** Whether two arrays hold the same numbers. */
export function sameNumbers(a: ArrayLike<number>, b: ArrayLike<number>): boolean {
  for (let i = 0; i < a.length; i++) {
    if (a[i] !== b[i]) {
      return false;
    }
  }
  return a.length === b.length;
}
