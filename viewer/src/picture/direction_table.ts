/** The texture of a table of directions. */

import { type DirectionSizes, rowDirection } from "../core/api";

/** Least squares by which the diffuse part is found, and what is above it, up to rounding. */
const [ROUNDS, ABOVE] = [3, 1.001];

/**
 * Texels (2 samples + 2, azimuths * cosines, 4) of a table (azimuths, cosines, samples, 8): half
 * vectors and log2 pdf, then weights, in turn; in the last rows the diffuse part, and the albedo.
 *
 * The diffuse part is an albedo d whose light is known from the irradiance; the weights are those of
 * f - d / pi (a control variate, Owen 2013, section 8.9). The half vectors of a lobe hardly depend on
 * the direction of the eye. They are interpolated between the cosines and azimuths, and each pixel
 * mirrors its own direction in them.
 *
 * @param isFirst whether the albedos are averaged over neighbouring cosines, against their noise.
 */
export function directionTexels(
  table: Float32Array,
  sizes: DirectionSizes,
  isFirst: boolean,
): Float32Array {
  const { azimuths, cosines, samples } = sizes;
  const columns = azimuths * cosines;
  const texels = new Float32Array(4 * columns * (2 * samples + 2));
  const last = texels.subarray(8 * columns * samples);
  const diffuse = diffusePart(table, sizes);
  for (let column = 0; column < columns; column++) {
    const wi = rowDirection(column, sizes);
    const rows = table.subarray(8 * column * samples, 8 * (column + 1) * samples);
    const albedo = diffuse.subarray(4 * (column % cosines), 4 * (column % cosines) + 3);
    for (let at = 0; at < rows.length; at += 8) {
      const [x, y, z] = [rows[at] + wi.x, rows[at + 1] + wi.y, rows[at + 2] + wi.z];
      const length = Math.hypot(x, y, z) || 1;
      const logPdf = Math.log2(Math.max(rows[at + 6], 1e-6));
      const rest = albedo.map((d, k) => rows[at + 3 + k] - d * diffuseWeight(rows, at));
      for (let k = 0; k < 3; k++) last[4 * (columns + column) + k] += rows[at + 3 + k] / samples;
      const to = columns * at + 4 * column;
      texels.set([x / length, y / length, z / length, logPdf], to);
      texels.set(rest, to + 4 * columns);
    }
    last.set(albedo, 4 * column);
  }
  if (isFirst) last.set(smoothed(last.subarray(4 * columns), cosines), 4 * columns);
  return texels;
}

/** The weight of a diffuse reflector of albedo 1 where the samples of a row were drawn. */
function diffuseWeight(rows: Float32Array, at: number): number {
  return rows[at + 6] > 0 ? rows[at + 2] / (Math.PI * rows[at + 6]) : 0;
}

/**
 * Albedos (cosines, 4) of a diffuse reflector below most of f.
 *
 * It is the one that is closest to the weights of all azimuths and of neighbouring cosines, in each
 * round to those that are below the reflector of the round before. A lobe that raised it would leave
 * dark parts of the picture as small differences of much light and of an estimate of it.
 */
function diffusePart(table: Float32Array, { cosines, samples }: DirectionSizes): Float32Array {
  let found = new Float32Array(4 * cosines).fill(Infinity);
  for (let round = 0; round < ROUNDS; round++) {
    const [products, squares] = [new Float32Array(4 * cosines), new Float32Array(4 * cosines)];
    for (let at = 0; at < table.length; at += 8) {
      const to = 4 * (Math.floor(at / (8 * samples)) % cosines);
      const weight = diffuseWeight(table, at);
      for (let k = 0; k < 3; k++) {
        if (table[at + 3 + k] > ABOVE * weight * found[to + k]) continue;
        products[to + k] += weight * table[at + 3 + k];
        squares[to + k] += weight * weight;
      }
    }
    const sums = smoothed(squares, cosines);
    found = smoothed(products, cosines).map((sum, at) => sum / Math.max(sums[at], 1e-9));
  }
  return found;
}

/** Columns (N, 4) averaged over neighbouring cosines; fewer where the albedo is steep. */
function smoothed(columns: Float32Array, cosines: number): Float32Array {
  return columns.map((_, at) => {
    const place = Math.floor(at / 4) % cosines;
    const half = Math.min(4, place >> 1, cosines - 1 - place);
    let sum = 0;
    for (let step = -half; step <= half; step++) sum += columns[at + 4 * step];
    return sum / (2 * half + 1);
  });
}
