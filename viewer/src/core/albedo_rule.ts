/**
 * A quadrature for the directional albedo at ten angles, and between them.
 *
 * A polynomial interpolates, clipped to the values at the two angles beside; see Python's
 * `material.albedo_rule`.
 */

// The same table that Python's `material.energy` reads.
import table from "../../../src/urushi/material/albedo_rule.csv?raw";
import { Pairs } from "./features";

/** The variable of the interpolating polynomial is ln(cos + this). */
const COSINE_OFFSET = 0.1;

/** Number of cosines, evenly spaced in that variable, at which the polynomial is evaluated. */
const INTERPOLATED_COSINES = 41;

/** Share by which the polynomial may leave the range of the values at the two angles beside it. */
const OVERSHOOT = 0.05;

export interface AlbedoRule {
  /** The M nodes: pairs of wi and wo, those of an angle one after the other. */
  readonly pairs: Pairs;
  /** (M, 3) their directions. */
  readonly wi: Float32Array;
  readonly wo: Float32Array;
  /** (M) of f, wo's cosine included. */
  readonly weights: Float64Array;
  /** The first node of each of K angles, and M. */
  readonly bounds: readonly number[];
  /** (D) cosines of wi at which albedos are interpolated. */
  readonly cosines: Float64Array;
  /** (D, K) from the albedos at the angles to those of the polynomial at `cosines`. */
  readonly polynomial: Float64Array;
  /** (D) index of the last angle whose cosine is not below that of `cosines`; K - 2 at the last. */
  readonly left: readonly number[];
  /** (K) cosines of the angles. */
  readonly angles: Float64Array;
}

/** Read the rule. */
export function albedoRule(): AlbedoRule {
  const lines = table.split("\n").filter((line) => line && !line.startsWith("#"));
  const rows = lines.map((line) => line.split(",").map(Number) as [number, ...number[]]);
  const wi = Float32Array.from(
    rows.flatMap(([cosine]) => [Math.sqrt(1 - cosine * cosine), 0, cosine]),
  );
  const wo = Float32Array.from(rows.flatMap((row) => row.slice(1, 4)));
  const starts = rows.flatMap((row, i) => (row[0] === rows[i - 1]?.[0] ? [] : [i]));
  const angles = starts.map((i) => Math.log((rows[i]?.[0] ?? 0) + COSINE_OFFSET));
  const [top = 0, bottom = 0] = [angles[0], angles[angles.length - 1]];
  const between = Float64Array.from(
    { length: INTERPOLATED_COSINES },
    (_, d) => top + ((bottom - top) * d) / (INTERPOLATED_COSINES - 1),
  );
  return {
    pairs: Pairs.of(wi, wo),
    wi,
    wo,
    weights: Float64Array.from(rows, (row) => row[4] as number),
    bounds: [...starts, rows.length],
    cosines: between.map((x) => Math.exp(x) - COSINE_OFFSET),
    polynomial: lagrange(angles, between),
    left: Array.from(between, (x) =>
      Math.min(angles.filter((angle) => angle >= x).length - 1, angles.length - 2),
    ),
    angles: Float64Array.from(starts, (i) => rows[i]?.[0] ?? 0),
  };
}

/** The matrix (X, N) from values at nodes to those of their polynomial at x. */
function lagrange(nodes: readonly number[], x: Float64Array): Float64Array {
  const matrix = new Float64Array(x.length * nodes.length);
  x.forEach((at, row) => {
    nodes.forEach((node, column) => {
      const others = nodes.filter((_, other) => other !== column);
      const factors = others.map((other) => (at - other) / (node - other));
      matrix[row * nodes.length + column] = factors.reduce((a, b) => a * b, 1);
    });
  });
  return matrix;
}

/** Add the albedos (D) of values f (M) at the rule's nodes to `albedos`. */
export function addAlbedos(rule: AlbedoRule, f: Float64Array, albedos: Float64Array): void {
  interpolatedAlbedos(rule, albedosAtAngles(rule, f)).forEach((albedo, d) => {
    albedos[d] += albedo;
  });
}

/** The albedos (K) of values f (M) at the rule's angles. */
export function albedosAtAngles(rule: AlbedoRule, f: Float64Array): Float64Array {
  const angles = rule.bounds.length - 1;
  const atAngles = new Float64Array(angles);
  for (let k = 0; k < angles; k++) {
    for (let i = rule.bounds[k]; i < rule.bounds[k + 1]; i++) {
      atAngles[k] += f[i] * rule.weights[i];
    }
  }
  return atAngles;
}

/** The albedos (D) between those (K) at the rule's angles. */
export function interpolatedAlbedos(rule: AlbedoRule, atAngles: Float64Array): Float64Array {
  const angles = atAngles.length;
  const albedos = new Float64Array(rule.cosines.length);
  for (let d = 0; d < albedos.length; d++) {
    let value = 0;
    for (let k = 0; k < angles; k++) {
      value += rule.polynomial[d * angles + k] * atAngles[k];
    }
    const [first, second] = [atAngles[rule.left[d]], atAngles[rule.left[d] + 1]];
    const least = Math.min(first, second) * (1 - OVERSHOOT);
    const most = Math.max(first, second) * (1 + OVERSHOOT);
    albedos[d] = Math.min(Math.max(value, least), most);
  }
  return albedos;
}
