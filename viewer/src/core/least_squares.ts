/** Small linear systems; see Python's `nets.least_squares`. */

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
