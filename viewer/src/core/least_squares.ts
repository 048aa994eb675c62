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
