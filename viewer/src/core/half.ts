/** Numbers of sixteen bits (IEEE 754). */

/** The number of bits. */
export function fromHalf(bits: number): number {
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

/** The bits of the nearest number, of two the even one; value: of a magnitude below 65504. */
export function toHalf(value: number): number {
  const size = Math.abs(value);
  const exponent = Math.max(Math.floor(Math.log2(size)), -14);
  // A fraction of 2048 carries into the exponent; one below 1024 is a number without leading one.
  const scaled = size * 2 ** (10 - exponent);
  const below = Math.floor(scaled);
  const isUp = scaled - below > 0.5 || (scaled - below === 0.5 && below % 2 === 1);
  const fraction = below + Number(isUp);
  return (value < 0 ? 0x8000 : 0) | (fraction + ((exponent + 14) << 10));
}
