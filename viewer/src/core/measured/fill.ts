/** Filling of bins that were not measured from those beside them; see Python's `tabulated`. */

/**
 * Find for every bin of a slice the valid bin whose value it takes.
 *
 * An invalid bin takes the nearest valid one along its column or along its row, which is periodic,
 * whichever is nearer, the row's if they are equally far. Bins with neither are filled in a further
 * round.
 *
 * @param valid (rows, columns), 1 or 0; at least one is 1.
 * @returns (rows, columns) the places of the sources.
 */
export function nearestValid(valid: Uint8Array, rows: number, columns: number): Int32Array {
  const source = Int32Array.from(valid, (isValid, place) => (isValid ? place : -1));
  const usable = valid.slice();
  while (usable.includes(0)) {
    const found: number[] = [];
    for (let row = 0; row < rows; row++) {
      for (let column = 0; column < columns; column++) {
        const place = row * columns + column;
        if (usable[place]) continue;
        const nearest = nearestUsable(usable, rows, columns, row, column);
        if (nearest >= 0) {
          source[place] = source[nearest];
          found.push(place);
        }
      }
    }
    for (const place of found) usable[place] = 1;
  }
  return source;
}

function nearestUsable(
  usable: Uint8Array,
  rows: number,
  columns: number,
  row: number,
  column: number,
): number {
  for (let distance = 1; distance < Math.max(rows, columns); distance++) {
    const candidates: number[] = [];
    if (distance < columns) {
      candidates.push(row * columns + ((column - distance + columns) % columns));
      candidates.push(row * columns + ((column + distance) % columns));
    }
    if (row >= distance) candidates.push((row - distance) * columns + column);
    if (row + distance < rows) candidates.push((row + distance) * columns + column);
    const nearest = candidates.find((place) => usable[place]);
    if (nearest !== undefined) return nearest;
  }
  return -1;
}
