/** Small linear systems, and the damped step of Gauss and Newton; see Python's `nets.least_squares`. */

/**
 * Solve a positive definite system by Gauss's elimination, which needs no exchange of rows here.
 *
 * @param matrix (size, size), which is overwritten.
 * @param right (size, columns), which becomes the solutions.
 */
export function solve(matrix: Float64Array, right: Float64Array, size: number): Float64Array {
  const columns = right.length / size;
  for (let i = 0; i < size; i++) {
    for (let j = i + 1; j < size; j++) {
      const share = matrix[j * size + i] / matrix[i * size + i];
      for (let k = i; k < size; k++) {
        matrix[j * size + k] -= share * matrix[i * size + k];
      }
      for (let k = 0; k < columns; k++) {
        right[j * columns + k] -= share * right[i * columns + k];
      }
    }
  }
  for (let i = size - 1; i >= 0; i--) {
    for (let c = 0; c < columns; c++) {
      let sum = right[i * columns + c];
      for (let k = i + 1; k < size; k++) {
        sum -= matrix[i * size + k] * right[k * columns + c];
      }
      right[i * columns + c] = sum / matrix[i * size + i];
    }
  }
  return right;
}

/**
 * Add a residual to slope and curvature.
 *
 * @param slopes its derivatives by the unknowns begin at a place of this array.
 * @param pull its weight times the residual.
 */
export function addRow(
  slope: Float64Array,
  curvature: Float64Array,
  slopes: ArrayLike<number>,
  at: number,
  pull: number,
  weight: number,
): void {
  const size = slope.length;
  for (let a = 0; a < size; a++) {
    const own = slopes[at + a];
    slope[a] += pull * own;
    for (let b = 0; b < size; b++) curvature[a * size + b] += weight * own * slopes[at + b];
  }
}

/** The state of a fit at x: what is minimised, half its gradient and half its Hessian. */
export interface FitState<X> {
  readonly x: X;
  readonly objective: number;
  readonly slope: Float64Array;
  readonly curvature: Float64Array;
}

/** The last state of damped steps, each accepted only if it lowers the objective. */
export function dampedSteps<X>(
  stateAt: (x: X) => FitState<X>,
  start: X,
  steps: number,
  [first, decrease, increase]: readonly [number, number, number],
  moved: (x: X, step: Float64Array) => X,
): FitState<X> {
  let state = stateAt(start);
  let damping: number = first;
  for (let k = 0; k < steps; k++) {
    const step = dampedStep(state.curvature.slice(), state.slope.slice(), damping);
    const found = stateAt(moved(state.x, step));
    const isBetter = found.objective < state.objective;
    if (isBetter) state = found;
    damping *= isBetter ? decrease : increase;
  }
  return state;
}

/** Solve (curvature + damping) x = slope (Marquardt 1963); both arrays are overwritten. */
export function dampedStep(
  curvature: Float64Array,
  slope: Float64Array,
  damping: number,
): Float64Array {
  const size = slope.length;
  let trace = 0;
  for (let i = 0; i < size; i++) {
    trace += curvature[i * size + i];
  }
  for (let i = 0; i < size; i++) {
    curvature[i * size + i] += (damping * trace) / size + 1e-12;
  }
  return solve(curvature, slope, size);
}
