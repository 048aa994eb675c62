/** A quadrature for the directional albedo at ten angles, and between them. */

// The same table that Python's `material.energy` reads.
import table from "../../../src/urushi/material/albedo_rule.csv?raw";
import { Pairs } from "./features";

/** The variable of the interpolating polynomial is ln(cos + this). */
const COSINE_OFFSET = 0.1;

/** Number of cosines, evenly spaced in that variable, at which the polynomial is evaluated. */
const INTERPOLATED_COSINES = 41;

export interface AlbedoRule {
  /** The M nodes: pairs of wi and wo, those of an angle one after the other. */
  readonly pairs: Pairs;
  /** (M) of f, wo's cosine included. */
  readonly weights: Float64Array;
  /** The first node of each of K angles, and M. */
  readonly bounds: readonly number[];
  /** (D) cosines of wi at which albedos are interpolated. */
  readonly cosines: Float64Array;
  /** (D, K) from the albedos at the angles to those at `cosines`. */
  readonly interpolation: Float64Array;
}

/** Read the rule. */
export function albedoRule(): AlbedoRule {
  const lines = table.split("\n").filter((line) => line && !line.startsWith("#"));
  const rows = lines.map((line) => line.split(",").map(Number) as [number, ...number[]]);
  const wi = rows.flatMap(([cosine]) => [Math.sqrt(1 - cosine * cosine), 0, cosine]);
  const wo = rows.flatMap((row) => row.slice(1, 4));
  const starts = rows.flatMap((row, i) => (row[0] === rows[i - 1]?.[0] ? [] : [i]));
  const angles = starts.map((i) => Math.log((rows[i]?.[0] ?? 0) + COSINE_OFFSET));
  const [top = 0, bottom = 0] = [angles[0], angles[angles.length - 1]];
  const between = Float64Array.from(
    { length: INTERPOLATED_COSINES },
    (_, d) => top + ((bottom - top) * d) / (INTERPOLATED_COSINES - 1),
  );
  return {
    pairs: Pairs.of(Float32Array.from(wi), Float32Array.from(wo)),
    weights: Float64Array.from(rows, (row) => row[4] as number),
    bounds: [...starts, rows.length],
    cosines: between.map((x) => Math.exp(x) - COSINE_OFFSET),
    interpolation: lagrange(angles, between),
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
  const angles = rule.bounds.length - 1;
  const atAngles = new Float64Array(angles);
  for (let k = 0; k < angles; k++) {
    for (let i = rule.bounds[k]; i < rule.bounds[k + 1]; i++) {
      atAngles[k] += f[i] * rule.weights[i];
    }
  }
  for (let d = 0; d < rule.cosines.length; d++) {
    for (let k = 0; k < angles; k++) {
      albedos[d] += rule.interpolation[d * angles + k] * atAngles[k];
    }
  }
}
