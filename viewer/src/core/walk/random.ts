/** A reproducible generator of uniform numbers. */

/** Uniform numbers in [0, 1) from a seed: xoshiro128** (Blackman and Vigna 2018). */
export function uniformNumbers(seed: number): () => number {
  let state = seed | 0;
  const scattered = () => {
    // The finaliser of MurmurHash3 scatters a counter's bits.
    state = (state + 0x9e3779b9) | 0;
    let x = state;
    x = Math.imul(x ^ (x >>> 16), 0x85ebca6b);
    x = Math.imul(x ^ (x >>> 13), 0xc2b2ae35);
    return x ^ (x >>> 16);
  };
  let [a, b, c, d] = [scattered(), scattered(), scattered(), scattered()];
  return () => {
    const product = Math.imul(b, 5);
    const result = Math.imul((product << 7) | (product >>> 25), 9);
    const shifted = b << 9;
    c ^= a;
    d ^= b;
    b ^= c;
    a ^= d;
    c ^= shifted;
    d = (d << 11) | (d >>> 21);
    return (result >>> 0) / 2 ** 32;
  };
}
