/**
 * Recognition of bare interfaces by their values: GGX with the exact Fresnel term; see Python's
 * `nets.interface_fit`.
 */

import type { Pairs } from "./features";
import { CHECKS, fresnel, INTERFACE_FIT, LOBE_FIT } from "./formulas";
import { dampedSteps, type FitState } from "./least_squares";
import { lobeValue } from "./lobe";
import { fitLobe, lobeShape } from "./lobe_fit";

const { LEAST_ERROR, GREATEST_ERROR, TOLERANCE, STEPS, METALS, DAMPING, DECREASE, INCREASE } =
  INTERFACE_FIT;
const { DARK } = LOBE_FIT;

/** Bounds of ln alpha, eta and k. */
const LOWER = [Math.log(CHECKS.MIN_ALPHA), ...INTERFACE_FIT.LOWER];
const UPPER = [0, ...INTERFACE_FIT.UPPER];

/** Relative difference of derivatives. */
const STEP = 1e-5;

/** The lobe (6) of a BRDF with values f [1/sr] at the probe pairs. */
export function findLobe(pairs: Pairs, f: Float64Array): Float32Array {
  const values = f.map((value) => Math.max(value, 0));
  const schlick = fitLobe(pairs, values);
  let sum = 0;
  values.forEach((value, i) => {
    sum += Math.abs(lobeValue(schlick, 0, pairs, i) - value) / (value + DARK);
  });
  const mean = sum / values.length;
  if (mean > LEAST_ERROR && mean < GREATEST_ERROR && schlick[1] > 0) {
    const { x, greatest } = fitted(pairs, values, schlick);
    if (greatest < TOLERANCE) {
      return Float32Array.of(Math.exp(x[0]), 0, 0, 1, x[1], x[2]);
    }
  }
  return Float32Array.from(schlick);
}

interface Fit extends FitState<readonly number[]> {
  /** The greatest relative error. */
  readonly greatest: number;
}

function fitted(pairs: Pairs, f: Float64Array, schlick: Float64Array): Fit {
  const root = Math.sqrt(Math.min(Math.max(schlick[1], 1e-4), 0.98));
  const bright = root * root;
  const glass = (1 + root) / (1 - root);
  const metals = METALS.map((eta) => {
    const square = (bright * (1 + eta) ** 2 - (1 - eta) ** 2) / (1 - bright);
    return [eta, Math.sqrt(Math.max(square, 0.1))] as const;
  });
  const starts = [[glass, 0], [1 / glass, 0], ...metals] as const;
  const all = starts.map(([eta, k]) => descend(pairs, f, [Math.log(schlick[0]), eta, k]));
  return all.reduce((a, b) => (b.greatest < a.greatest ? b : a));
}

function descend(pairs: Pairs, f: Float64Array, start: readonly number[]): Fit {
  const stateAt = (x: readonly number[]) => fitAt(pairs, f, x);
  return dampedSteps(stateAt, clipped(start), STEPS, [DAMPING, DECREASE, INCREASE], (x, step) =>
    clipped(x.map((number, k) => number - step[k])),
  ) as Fit;
}

/** The state at unknowns; derivatives are differences. */
function fitAt(pairs: Pairs, f: Float64Array, x: readonly number[]): Fit {
  const error = errorsAt(pairs, f, x);
  const slopes = x.map((_, a) => {
    const beside = errorsAt(pairs, f, x.with(a, x[a] + STEP));
    return beside.map((value, i) => (value - error[i]) / STEP);
  });
  return {
    x,
    objective: dot(error, error),
    slope: Float64Array.from(slopes, (own) => dot(own, error)),
    curvature: Float64Array.from(slopes.flatMap((a) => slopes.map((b) => dot(a, b)))),
    greatest: error.reduce((most, value) => Math.max(most, Math.abs(value)), 0),
  };
}

/** Relative errors of unknowns ln alpha, eta and k. */
function errorsAt(pairs: Pairs, f: Float64Array, [log, eta, k]: readonly number[]): Float64Array {
  const shape = lobeShape(pairs, Math.exp(log));
  return f.map((value, i) => (shape[i] * fresnel(pairs.cosD[i], eta, k) - value) / (value + DARK));
}

function clipped(x: readonly number[]): number[] {
  return x.map((number, k) => Math.min(Math.max(number, LOWER[k]), UPPER[k]));
}

function dot(a: Float64Array, b: Float64Array): number {
  let sum = 0;
  for (let i = 0; i < a.length; i++) {
    sum += a[i] * b[i];
  }
  return sum;
}
