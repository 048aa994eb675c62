/** Roberts' low-discrepancy R sequence (2018) in three dimensions. */

export type Point = readonly [number, number, number];

/** Powers of the inverse of the root of x^4 = x + 1. */
const STEPS: Point = [0.8191725133961644, 0.671043606703789, 0.5497004779019702];

/** Point n of the sequence, in [0, 1)^3, from a start. */
export function sequencePoint(n: number, start: Point): Point {
  const at = (k: 0 | 1 | 2) => {
    const x = start[k] + n * STEPS[k];
    return x - Math.floor(x);
  };
  return [at(0), at(1), at(2)];
}
