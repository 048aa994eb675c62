/**
 * Codes of known values: reweighted least squares in the linear basis (Lawson 1961).
 *
 * The error of a code is the light that it gets wrong at the probes over the light of the rest. Each
 * round solves a quadratic problem in the logarithm whose weights make it equal to the error at the
 * last code. The best code of all rounds is kept; see Python's `nets.code_fit`.
 */

import { BASIS, CODE_FIT, TABLE } from "./formulas";
import { addRow, solve } from "./least_squares";

const { FIRST_FLOOR, FLOOR, KNEE, DARK, PRIOR, ROUNDS, LEAST_SHARE, LEAST_REST } = CODE_FIT;

/**
 * The code (K) of a material.
 *
 * @param rows (N, 1 + K) the mean and the functions at the probe pairs.
 * @param measure (N) shares of the pairs in integrals.
 * @param prior (K, K) inverse covariance of codes.
 * @param rest values (N) [1/sr] of the rest.
 */
export function fittedCode(
  rows: Float64Array,
  measure: Float64Array,
  prior: Float64Array,
  rest: Float64Array,
): Float64Array {
  const count = Math.sqrt(prior.length);
  const width = 1 + count;
  const mean = dot(measure, rest);
  if (mean < LEAST_REST)
    return Float64Array.from({ length: count }, (_, k) => (k ? 0 : BASIS.EMPTY_GAIN));
  const light = Math.max(mean, 1e-12);
  const f = rest.map((value) => Math.max(value, LEAST_SHARE * mean + 1e-12));
  const logs = f.map(Math.log);

  const solved = (weights: Float64Array): Float64Array => {
    const normal = prior.map((value) => PRIOR * value);
    const right = new Float64Array(count);
    f.forEach((_, i) => {
      const at = i * width;
      addRow(right, normal, rows, at + 1, weights[i] * (logs[i] - rows[at]), weights[i]);
    });
    return solve(normal, right, count);
  };

  let code = solved(f.map((value, i) => measure[i] * (value / light + FIRST_FLOOR)));
  let [best, least] = [code, Number.POSITIVE_INFINITY];
  for (let round = 0; round <= ROUNDS; round++) {
    let error = 0;
    const weights = f.map((value, i) => {
      const at = i * width;
      let log = rows[at];
      for (let k = 0; k < count; k++) log += rows[at + 1 + k] * code[k];
      log = Math.min(log, TABLE.MAX_LOG);
      const [apart, off] = [Math.exp(log) - value, log - logs[i]];
      const slope = Math.abs(off) < 1e-3 ? value : apart / off;
      const size = Math.abs(apart);
      error += size * measure[i];
      const weight = (slope * slope) / (light * (size + KNEE * (value + DARK * light)));
      return measure[i] * (weight + FLOOR);
    });
    if (error < least) [best, least] = [code, error];
    if (round < ROUNDS) code = solved(weights);
  }
  return best;
}

function dot(a: Float64Array, b: Float64Array): number {
  return a.reduce((sum, value, i) => sum + value * b[i], 0);
}
