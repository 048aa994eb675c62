/**
 * Recognition of bare interfaces by their values: GGX with the exact Fresnel term; see Python's
 * `nets.interface_fit`.
 */

import type { Pairs } from "./features";
import { dampedStep } from "./least_squares";
import { fresnel, lobeValue } from "./lobe";
import { DARK, fitLobe, LEAST_LOG, lobeShape } from "./lobe_fit";

/** Mean relative error of Schlick's term between which an exact one is looked for. */
const LEAST_ERROR = 2e-3;
const GREATEST_ERROR = 0.15;

/** Greatest relative error of any value that the exact term may leave. */
const TOLERANCE = 0.005;

/** Steps, the first damping, and its factors after steps that lower the error and that do not. */
const STEPS = 20;
const DAMPING = 1e-3;
const DECREASE = 0.2;
const INCREASE = 10;

/** Bounds of ln alpha, eta and k. */
const LOWER = [LEAST_LOG, 0.02, 0];
const UPPER = [0, 8, 12];

/** Indices of the metals that are tried. */
const METALS = [0.2, 1, 2.5];

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

interface Fit {
  /** ln alpha, eta and k. */
  readonly x: readonly number[];
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
  let x = clipped(start);
  let state = errorsAt(pairs, f, x);
  let damping = DAMPING;
  for (let step = 0; step < STEPS; step++) {
    const curvature = new Float64Array(9);
    const slope = new Float64Array(3);
    for (let a = 0; a < 3; a++) {
      slope[a] = dot(state.slopes[a], state.error);
      for (let b = 0; b < 3; b++) {
        curvature[3 * a + b] = dot(state.slopes[a], state.slopes[b]);
      }
    }
    const change = dampedStep(curvature, slope, damping);
    const next = clipped(x.map((number, k) => number - change[k]));
    const found = errorsAt(pairs, f, next);
    const isBetter = dot(found.error, found.error) < dot(state.error, state.error);
    if (isBetter) {
      [x, state] = [next, found];
    }
    damping *= isBetter ? DECREASE : INCREASE;
  }
  return { x, greatest: state.error.reduce((most, error) => Math.max(most, Math.abs(error)), 0) };
}

/** Relative errors of unknowns, and their derivatives. */
function errorsAt(
  pairs: Pairs,
  f: Float64Array,
  [log, eta, k]: readonly number[],
): { error: Float64Array; slopes: Float64Array[] } {
  const alpha = Math.exp(log);
  const shape = lobeShape(pairs, alpha);
  const wider = lobeShape(pairs, alpha * (1 + STEP));
  const error = new Float64Array(f.length);
  const slopes = [0, 1, 2].map(() => new Float64Array(f.length));
  for (let i = 0; i < f.length; i++) {
    const scale = 1 / (f[i] + DARK);
    const cosine = pairs.cosD[i];
    const reflected = fresnel(cosine, eta, k);
    error[i] = (shape[i] * reflected - f[i]) * scale;
    slopes[0][i] = ((wider[i] - shape[i]) / STEP) * reflected * scale;
    slopes[1][i] = shape[i] * ((fresnel(cosine, eta + STEP, k) - reflected) / STEP) * scale;
    slopes[2][i] = shape[i] * ((fresnel(cosine, eta, k + STEP) - reflected) / STEP) * scale;
  }
  return { error, slopes };
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
