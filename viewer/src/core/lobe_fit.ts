/**
 * The analytic lobe of a BRDF that is known by its values alone; see Python's `nets.lobe_fit`.
 *
 * A BRDF is approximated by a diffuse term and one GGX lobe with Schlick's Fresnel term. Relative
 * errors above the values count much more than those below.
 */

import type { Pairs } from "./features";
import { CHECKS, LOBE, LOBE_FIT } from "./formulas";
import { addRow, solve } from "./least_squares";
import { lobeValues } from "./lobe";

const { DARK, OVERSHOOT_WEIGHT, KNEE, STEPS, CONVERGED, LONGEST_STEP, LAST_STEPS } = LOBE_FIT;

/** Logarithm of the least width, and the widths that are tried first. */
const LEAST_LOG = Math.log(CHECKS.MIN_ALPHA);
const GRID = Array.from({ length: 24 }, (_, k) => Math.exp(LEAST_LOG * (1 - k / 23)));

/** Bounds of the diffuse term, the two factors and ln alpha. */
const LOWER = [0, 0, 0, LEAST_LOG];
const UPPER = [Number.POSITIVE_INFINITY, 1, 1, 0];

/** The lobe (6) with Schlick's term of a BRDF with values f [1/sr] at the probe pairs. */
export function fitLobe(pairs: Pairs, f: Float64Array): Float32Array {
  let x = bestWidth(pairs, f);
  for (let step = 0; step < STEPS; step++) {
    const change = stepFrom(pairs, f, x, step < STEPS - LAST_STEPS ? LONGEST_STEP : 0);
    x = x.map((number, k) => number + change[k]);
    if (change.every((number) => Math.abs(number) <= CONVERGED)) {
      break;
    }
  }
  return Float32Array.of(Math.exp(x[3]), x[1], x[2], ...LOBE.NO_LOBE.slice(3));
}

/** The lobe (count) [1/sr] of a width for a reflectance of one. */
function lobeShape(pairs: Pairs, alpha: number): Float64Array {
  return lobeValues([alpha, 1, 1, 0, 1.5, 0], pairs);
}

/** Schlick's share of the reflectance at grazing incidence at pair `i`. */
function grazingShare(pairs: Pairs, i: number): number {
  return (1 - pairs.cosD[i]) ** 5;
}

/** The best factors of the best width: diffuse, normal, grazing, ln alpha. */
function bestWidth(pairs: Pairs, f: Float64Array): Float64Array {
  let best = Float64Array.of(0, 0, 0, Math.log(GRID[0]));
  let most = Number.NEGATIVE_INFINITY;
  for (const alpha of GRID) {
    const shape = lobeShape(pairs, alpha);
    const normal = new Float64Array(9);
    const slope = new Float64Array(3);
    for (let i = 0; i < f.length; i++) {
      const weight = 1 / (f[i] + DARK) ** 2;
      const grazing = grazingShare(pairs, i);
      const columns = [1 / Math.PI, shape[i] * (1 - grazing), shape[i] * grazing];
      addRow(slope, normal, columns, 0, weight * f[i], weight);
    }
    const factors = bounded(normal, slope, [0, 0, 0], [Infinity, Infinity, Infinity]);
    const bend = product(normal, factors);
    const gain = factors.reduce((sum, x, k) => sum + x * (2 * slope[k] - bend[k]), 0);
    if (gain > most) {
      most = gain;
      best = Float64Array.of(...factors, Math.log(alpha));
    }
  }
  return best;
}

/** The step of Gauss and Newton's method from unknowns (4). */
function stepFrom(pairs: Pairs, f: Float64Array, x: Float64Array, longest: number): Float64Array {
  const [diffuse, normal, grazing] = x;
  const alpha = Math.exp(x[3]);
  const shape = lobeShape(pairs, alpha);
  const curvature = new Float64Array(16);
  const ahead = new Float64Array(4);
  for (let i = 0; i < f.length; i++) {
    const scale = 1 / (f[i] + DARK);
    const share = grazingShare(pairs, i);
    const scaled = shape[i] * scale;
    const lobe = scaled * (normal * (1 - share) + grazing * share);
    const white = scale / Math.PI;
    const columns = [
      white,
      scaled * (1 - share),
      scaled * share,
      lobe * shapeSlope(pairs, i, alpha),
    ];
    const error = lobe + diffuse * white - f[i] * scale;
    const weight = error > 0 ? OVERSHOOT_WEIGHT : KNEE / Math.max(-error, KNEE);
    addRow(ahead, curvature, columns, 0, -weight * error, weight);
  }
  const reach = [Infinity, Infinity, Infinity, longest];
  return bounded(
    curvature,
    ahead,
    LOWER.map((bound, k) => Math.max(bound - x[k], -reach[k])),
    UPPER.map((bound, k) => Math.min(bound - x[k], reach[k])),
  );
}

/** The derivative of the logarithm of the lobe's shape by ln alpha. */
function shapeSlope(pairs: Pairs, i: number, alpha: number): number {
  const alpha2 = alpha * alpha;
  const [ix, iy, cosI, ox, oy, cosO] = pairs.directions.subarray(6 * i, 6 * i + 6);
  const along = alpha2 * (cosI + cosO) ** 2;
  let slope = 2 - (4 * along) / (along + (ix + ox) ** 2 + (iy + oy) ** 2);
  for (const cosine of [cosI, cosO]) {
    const sine2 = 1 - cosine * cosine;
    const root = Math.sqrt(alpha2 * sine2 + cosine * cosine);
    slope -= (alpha2 * sine2) / ((root + cosine) * root);
  }
  return slope;
}

/**
 * Lower x' normal x / 2 - slope' x within bounds, which contain zero.
 *
 * From the minimum without bounds, unknowns that exceed a bound are fixed there, and the others
 * solved again. The result is the minimum in most cases, and never worse than zero.
 */
function bounded(
  normal: Float64Array,
  slope: Float64Array,
  lower: readonly number[],
  upper: readonly number[],
): Float64Array {
  const size = slope.length;
  // In units in which the curvature's diagonal is one
  const unit = slope.map((_, i) => 1 / Math.sqrt(normal[i * size + i] + 1e-30));
  const scaled = normal.map((value, at) => {
    const [i, j] = [Math.floor(at / size), at % size];
    return value * unit[i] * unit[j] + (i === j ? 1e-12 : 0);
  });
  const right = slope.map((value, i) => value * unit[i]);
  const low = unit.map((value, i) => lower[i] / value);
  const high = unit.map((value, i) => upper[i] / value);
  const clipped = (values: Float64Array) =>
    values.map((value, i) => Math.min(Math.max(value, low[i]), high[i]));
  let x = solve(scaled.slice(), right.slice(), size);
  const isFixed = Array.from(x, () => false);
  for (let round = 0; round < size - 1; round++) {
    const outside = Array.from(x, (value, i) => value < low[i] || value > high[i]);
    if (!outside.includes(true)) {
      return x.map((value, i) => value * unit[i]);
    }
    outside.forEach((isOutside, i) => {
      isFixed[i] ||= isOutside;
    });
    const kept = clipped(x).map((value, i) => (isFixed[i] ? value : 0));
    const bend = product(scaled, kept);
    const reduced = scaled.map((value, at) => {
      const [i, j] = [Math.floor(at / size), at % size];
      return isFixed[i] || isFixed[j] ? Number(i === j) : value;
    });
    x = solve(
      reduced,
      kept.map((value, i) => (isFixed[i] ? value : right[i] - bend[i])),
      size,
    );
  }
  x = clipped(x);
  const bend = product(scaled, x);
  const dot = (a: Float64Array) => a.reduce((sum, value, i) => sum + value * x[i], 0);
  const share = Math.min(Math.max(dot(right) / Math.max(dot(bend), 1e-30), 0), 1);
  return x.map((value, i) => value * share * unit[i]);
}

/** The product of a symmetric matrix and a vector. */
function product(matrix: Float64Array, x: Float64Array): Float64Array {
  const size = x.length;
  return x.map((_, i) => {
    let sum = 0;
    for (let j = 0; j < size; j++) {
      sum += matrix[i * size + j] * x[j];
    }
    return sum;
  });
}
