/** Spectra of reflection as linear sRGB; see Python's `measured.rgl.srgb_weights`. */

// The same table that Python reads: wavelength, the CIE 1931 observer, and D65.
import table from "../../../../src/urushi/measured/cie.csv?raw";

/** The visible range [nm]. */
export const VISIBLE = [380, 780] as const;

/** CIE XYZ to linear sRGB (IEC 61966-2-1), by rows. */
const XYZ_TO_SRGB = [
  [3.2406, -1.5372, -0.4986],
  [-0.9689, 1.8758, 0.0415],
  [0.0557, -0.204, 1.057],
] as const;

/**
 * Weights (W, 3) of a spectrum's samples, whose sum is linear sRGB under the illuminant D65.
 *
 * The spectrum is linear between its samples and constant outside; a constant one is neutral.
 *
 * @param wavelengths (W), W >= 2, increasing [nm].
 */
export function srgbWeights(wavelengths: ArrayLike<number>): Float64Array {
  const rows = table
    .split("\n")
    .filter((line) => line && !line.startsWith("#"))
    .map((line) => line.split(",").map(Number));
  const nodes = rows.map((row) => row[0] as number);
  const column = (k: number, nm: number) =>
    interpolated(
      nodes,
      rows.map((row) => row[k] as number),
      nm,
    );
  const weights = new Float64Array(3 * wavelengths.length);
  const sums = [0, 0, 0];
  for (let nm = VISIBLE[0]; nm <= VISIBLE[1]; nm++) {
    const light = column(4, nm);
    const xyz = [1, 2, 3].map((k) => column(k, nm) * light) as [number, number, number];
    let lower = 0;
    while (lower < wavelengths.length - 2 && wavelengths[lower + 1] < nm) lower++;
    const gap = wavelengths[lower + 1] - wavelengths[lower];
    const share = Math.min(Math.max((nm - wavelengths[lower]) / gap, 0), 1);
    XYZ_TO_SRGB.forEach(([x, y, z], k) => {
      const value = x * xyz[0] + y * xyz[1] + z * xyz[2];
      weights[3 * lower + k] += (1 - share) * value;
      weights[3 * (lower + 1) + k] += share * value;
      sums[k] += value;
    });
  }
  return weights.map((weight, k) => weight / sums[k % 3]);
}

function interpolated(nodes: readonly number[], values: readonly number[], x: number): number {
  const above = nodes.findIndex((node) => node >= x);
  if (above <= 0) return (above === 0 ? values[0] : values.at(-1)) as number;
  const [a, b] = [nodes[above - 1] as number, nodes[above] as number];
  const share = (x - a) / (b - a);
  return (1 - share) * (values[above - 1] as number) + share * (values[above] as number);
}
