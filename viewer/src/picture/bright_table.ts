/** The pairs of directions at which f is tabulated for bright lights, and the table's axes. */

/** Numbers of half angles, difference angles, and differences of the cosines. */
export interface TableSize {
  halves: number;
  differences: number;
  slants: number;
}

export const COARSE: TableSize = { halves: 64, differences: 16, slants: 8 };
export const FINE: TableSize = { halves: 160, differences: 24, slants: 12 };

/** The tangent of the half angle is logarithmic above NEAR, and ends at FAR. */
export const NEAR = 0.004;
export const FAR = 12;

/** Least cosine to the normal: below it, the table continues the last value. */
export const LEAST = 0.015;

/** Directions wi, wo (N, 3), the half angle fastest. */
export function brightPairs(size: TableSize): { wi: Float32Array; wo: Float32Array } {
  const count = size.halves * size.differences * size.slants;
  const wi = new Float32Array(3 * count);
  const wo = new Float32Array(3 * count);
  let at = 0;
  for (let k = 0; k < size.slants; k++)
    for (let j = 0; j < size.differences; j++)
      for (let i = 0; i < size.halves; i++) {
        const tangent = NEAR * ((1 + FAR / NEAR) ** (i / (size.halves - 1)) - 1);
        const cosHalf = 1 / Math.hypot(1, tangent);
        const sinHalf = tangent * cosHalf;
        const difference = (Math.PI / 2) * (j / (size.differences - 1));
        // `slant` is the cosine of the azimuth about the half vector.
        const slant = k / (size.slants - 1);
        const across = Math.sqrt(Math.max(1 - slant * slant, 0));
        for (const [target, sign] of [
          [wi, 1],
          [wo, -1],
        ] as const) {
          const along = Math.sin(difference) * slant * sign;
          const x = sinHalf * Math.cos(difference) - cosHalf * along;
          const y = Math.sin(difference) * across * sign;
          const z = Math.max(cosHalf * Math.cos(difference) + sinHalf * along, LEAST);
          const length = Math.hypot(x, y, z);
          target.set([x / length, y / length, z / length], at);
        }
        at += 3;
      }
  return { wi, wo };
}

/** (N, 4): the logarithm of f (N, 3), and a zero. */
export function brightTexels(f: Float32Array): Float32Array {
  const texels = new Float32Array((f.length / 3) * 4);
  for (let from = 0, to = 0; from < f.length; from += 3, to += 4)
    for (let k = 0; k < 3; k++) texels[to + k] = Math.log(Math.max(f[from + k]!, 1e-8));
  return texels;
}

/**
 * Texels (2 samples + 1, azimuths * cosines, 4) of a table (azimuths, cosines, samples, 8): half
 * vectors and log2 pdf, then weights; in the last row the mean weight, which is the albedo.
 *
 * The half vectors of a lobe hardly depend on the direction of the eye. They are interpolated
 * between the cosines and azimuths, and each pixel mirrors its own direction in them.
 *
 * @param isSmooth whether the albedo is averaged over neighbouring cosines, against its noise.
 */
export function directionTexels(
  table: Float32Array,
  cosines: number,
  samples: number,
  azimuths = 1,
  isSmooth = false,
): Float32Array {
  const columns = azimuths * cosines;
  const texels = new Float32Array(4 * columns * (2 * samples + 1));
  const last = 8 * columns * samples;
  for (let row = 0; row < columns; row++) {
    const cosine = ((row % cosines) + 0.5) / cosines;
    const sine = Math.sqrt(1 - cosine * cosine);
    const azimuth = (0.5 * Math.PI * Math.floor(row / cosines)) / Math.max(azimuths - 1, 1);
    const [along, across] = [sine * Math.cos(azimuth), sine * Math.sin(azimuth)];
    for (let sample = 0; sample < samples; sample++) {
      const from = 8 * (row * samples + sample);
      const to = 4 * (2 * sample * columns + row);
      const [x, y] = [table[from]! + along, table[from + 1]! + across];
      const z = table[from + 2]! + cosine;
      const length = Math.hypot(x, y, z) || 1;
      texels.set([x / length, y / length, z / length], to);
      texels[to + 3] = Math.log2(Math.max(table[from + 6]!, 1e-6));
      texels.set(table.subarray(from + 3, from + 6), to + 4 * columns);
      for (let k = 0; k < 3; k++) texels[last + 4 * row + k]! += table[from + 3 + k]! / samples;
    }
  }
  if (isSmooth) texels.set(smoothed(texels.subarray(last), cosines), last);
  return texels;
}

/** Columns (N, 4) averaged over neighbouring cosines; fewer where the albedo is steep. */
function smoothed(columns: Float32Array, cosines: number): Float32Array {
  return columns.map((_, at) => {
    const place = Math.floor(at / 4) % cosines;
    const half = Math.min(4, place >> 1, cosines - 1 - place);
    let sum = 0;
    for (let step = -half; step <= half; step++) sum += columns[at + 4 * step]!;
    return sum / (2 * half + 1);
  });
}
