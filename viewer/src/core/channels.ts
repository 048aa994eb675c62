/** The codes of a material's channels. */

/** Number of channels of every material. */
export const CHANNELS = 3;

/** The codes (L) of all channels, which share the memory of codes (3, L). */
export function rows(codes: Float32Array, size: number): Float32Array[] {
  return Array.from({ length: CHANNELS }, (_, row) => codes.subarray(row * size, (row + 1) * size));
}

/** Codes (3, L) of those of the channels. */
export function joined(codes: readonly Float32Array[]): Float32Array {
  return Float32Array.from(codes.flatMap((code) => [...code]));
}

/** Codes (3, L) by a function of the channel, called once for channels of the same numbers. */
export function perChannel(
  numbersOf: (channel: number) => ArrayLike<number>,
  codeOf: (channel: number) => Float32Array,
): Float32Array {
  const known = new Map<string, Float32Array>();
  const codes = Array.from({ length: CHANNELS }, (_, channel) => {
    const key = Array.from(numbersOf(channel)).join();
    const code = known.get(key) ?? codeOf(channel);
    known.set(key, code);
    return code;
  });
  return joined(codes);
}
