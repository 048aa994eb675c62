/** Bilinear grids on the unit square, one per elevation, and warps; see Python's `measured.warp`. */

/** Two slices, and their weights. */
export type Slices = readonly (readonly [slice: number, weight: number])[];

/** The slices around a parameter; the nodes increase, and beyond them the last ones count. */
export function slicesAt(nodes: ArrayLike<number>, parameter: number): Slices {
  let lower = 0;
  while (lower < nodes.length - 2 && nodes[lower + 1] < parameter) lower++;
  const share = (parameter - nodes[lower]) / (nodes[lower + 1] - nodes[lower]);
  const weight = Math.min(Math.max(share, 0), 1);
  return [
    [lower, 1 - weight],
    [lower + 1, weight],
  ];
}

/** The cell around a number in [0, 1], and the place in it. */
export function cellAt(u: number, nodes: number): [cell: number, place: number] {
  const position = Math.min(Math.max(u, 0), 1) * (nodes - 1);
  const cell = Math.min(Math.floor(position), nodes - 2);
  return [cell, position - cell];
}

/**
 * The warp of the uniform density on the unit square to a density that is bilinear on a grid.
 *
 * It acts along x given y, then along y. Between slices the densities and their integrals are
 * interpolated, not the warps.
 */
export class Warp {
  private readonly density: Float64Array;
  private readonly conditional: Float64Array;
  private readonly marginal: Float64Array;

  /** @param density (slices, rows, columns), not negative, none of the slices zero. */
  constructor(
    density: Float64Array,
    private readonly rows: number,
    private readonly columns: number,
  ) {
    const slices = density.length / (rows * columns);
    this.density = density.slice();
    this.conditional = new Float64Array(density.length);
    this.marginal = new Float64Array(slices * rows);
    const size = rows * columns;
    for (let slice = 0; slice < slices; slice++) {
      const own = (array: Float64Array) => array.subarray(slice * size, (slice + 1) * size);
      const marginal = this.marginal.subarray(slice * rows, (slice + 1) * rows);
      const conditional = own(this.conditional);
      const row = (array: Float64Array, j: number) =>
        array.subarray(j * columns, (j + 1) * columns);
      for (let j = 0; j < rows; j++) integrate(row(own(this.density), j), row(conditional, j));
      const whole = Float64Array.from(marginal, (_, j) => conditional[(j + 1) * columns - 1]);
      integrate(whole, marginal);
      const total = marginal[rows - 1];
      for (const array of [own(this.density), conditional, marginal]) {
        for (let k = 0; k < array.length; k++) array[k] /= total;
      }
    }
  }

  /** The point in [0, 1]^2 that the warp maps to (u, v). */
  invert(u: number, v: number, slices: Slices): [number, number] {
    const { rows, columns, density, conditional } = this;
    const [column, x] = cellAt(u, columns);
    const [row, y] = cellAt(v, rows);
    const at = (table: Float64Array, j: number, i: number) =>
      slices.reduce((sum, [s, weight]) => sum + weight * table[(s * rows + j) * columns + i], 0);
    const betweenRows = (table: Float64Array, i: number) =>
      (1 - y) * at(table, row, i) + y * at(table, row + 1, i);
    const left = betweenRows(density, column);
    const right = betweenRows(density, column + 1);
    const part = betweenRows(conditional, column) + x * (left + 0.5 * x * (right - left));
    const whole = betweenRows(conditional, columns - 1);
    const lower = at(conditional, row, columns - 1);
    const upper = at(conditional, row + 1, columns - 1);
    const marginal = slices.reduce(
      (sum, [s, weight]) => sum + weight * this.marginal[s * rows + row],
      0,
    );
    const below = marginal + y * (lower + 0.5 * y * (upper - lower));
    const clamped = (value: number) => Math.min(Math.max(value, 0), 1);
    // A row without density maps every x to the same point.
    return [clamped(whole > 0 ? part / whole : part), clamped(below)];
  }
}

/** Integrals from the first node to each, of linear pieces. */
function integrate(values: Float64Array, integrals: Float64Array): void {
  integrals[0] = 0;
  for (let k = 1; k < values.length; k++) {
    integrals[k] = integrals[k - 1] + 0.5 * (values[k] + values[k - 1]);
  }
}
