/** Linear least squares with few unknowns. */

/**
 * The unknowns x (K) of least |rows x - values|, by the normal equations.
 *
 * @param rows (N, K), with independent columns.
 * @param values (N)
 */
export function leastSquares(rows: Float64Array, values: Float64Array): Float64Array {
  const size = rows.length / values.length;
  const matrix = new Float64Array(size * size);
  const x = new Float64Array(size);
  values.forEach((value, row) => {
    for (let i = 0, at = row * size; i < size; i++) {
      x[i] += rows[at + i] * value;
      for (let k = 0; k < size; k++) matrix[i * size + k] += rows[at + i] * rows[at + k];
    }
  });
  // Gauss's elimination: the matrix is positive definite, so no rows are exchanged.
  for (let i = 0; i < size; i++)
    for (let j = i + 1; j < size; j++) {
      const share = matrix[j * size + i] / matrix[i * size + i];
      for (let k = i; k < size; k++) matrix[j * size + k] -= share * matrix[i * size + k];
      x[j] -= share * x[i];
    }
  for (let i = size - 1; i >= 0; i--) {
    for (let k = i + 1; k < size; k++) x[i] -= matrix[i * size + k] * x[k];
    x[i] /= matrix[i * size + i];
  }
  return x;
}
