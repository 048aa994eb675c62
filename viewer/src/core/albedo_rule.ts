/**
 * A quadrature for the directional albedo at ten angles, and between them.
 *
 * A polynomial interpolates, clipped to the values at the two angles beside; see Python's
 * `material.albedo_rule`. For anisotropic codes the angles are repeated at azimuths of one quadrant.
 */

// The same table that Python's `material.energy` reads.
import table from "../../../src/urushi/material/albedo_rule.csv?raw";
import { Pairs, type Widths } from "./features";
import { ALBEDO_RULE } from "./formulas";
import { gaussLegendre } from "./quadrature";

const { COSINE_OFFSET, INTERPOLATED_COSINES, OVERSHOOT, AZIMUTHS, ANISOTROPIC_COSINES } =
  ALBEDO_RULE;
const { POLAR_NODES, QUADRANT_NODES, CROWDING, LEAST_TANGENT } = ALBEDO_RULE;

/** K and D count the angles of all azimuths, one azimuth after the other. */
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

/** The rule of codes of one GGX width or two. */
export function albedoRule(widths: Widths): AlbedoRule {
  return widths === 1 ? isotropicRule() : anisotropicRule();
}

/** The rule of the table. */
function isotropicRule(): AlbedoRule {
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
    left: leftOf(angles, between),
    angles: Float64Array.from(starts, (i) => rows[i]?.[0] ?? 0),
  };
}

/** Half vectors logarithmic in tan theta_h, dense in azimuth near the xz and the yz plane. */
function anisotropicRule(): AlbedoRule {
  const wi: number[] = [];
  const wo: number[] = [];
  const weights: number[] = [];
  const bounds: number[] = [];
  for (const azimuth of AZIMUTHS)
    for (const cosine of ANISOTROPIC_COSINES) {
      bounds.push(weights.length);
      addHalfVectorNodes(azimuth, cosine, wi, wo, weights);
    }
  const angles = ANISOTROPIC_COSINES.map((cosine) => Math.log(cosine + COSINE_OFFSET));
  const [top = 0, bottom = 0] = [angles[0], angles[angles.length - 1]];
  const between = Float64Array.from(
    { length: INTERPOLATED_COSINES },
    (_, d) => top + ((bottom - top) * d) / (INTERPOLATED_COSINES - 1),
  );
  const [rows, columns] = [between.length, angles.length];
  const one = lagrange(angles, between);
  const polynomial = new Float64Array(one.length * AZIMUTHS.length ** 2);
  const left = AZIMUTHS.flatMap((_, block) => {
    for (let d = 0; d < rows; d++) {
      const row = (block * rows + d) * columns * AZIMUTHS.length;
      polynomial.set(one.subarray(d * columns, (d + 1) * columns), row + block * columns);
    }
    return leftOf(angles, between).map((index) => index + block * columns);
  });
  const floats = [wi, wo].map((numbers) => Float32Array.from(numbers)) as [
    Float32Array,
    Float32Array,
  ];
  return {
    pairs: Pairs.of(...floats, 2),
    wi: floats[0],
    wo: floats[1],
    weights: Float64Array.from(weights),
    bounds: [...bounds, weights.length],
    cosines: Float64Array.from(
      AZIMUTHS.flatMap(() => Array.from(between, (x) => Math.exp(x) - COSINE_OFFSET)),
    ),
    polynomial,
    left,
    angles: Float64Array.from(AZIMUTHS.flatMap(() => [...ANISOTROPIC_COSINES])),
  };
}

/** Add the directions of one wi, and the weights of f, wo's cosine included. */
function addHalfVectorNodes(
  azimuth: number,
  cosine: number,
  wi: number[],
  wo: number[],
  weights: number[],
): void {
  const sine = Math.sqrt(1 - cosine * cosine);
  const incident = [sine * Math.cos(azimuth), sine * Math.sin(azimuth), cosine] as const;
  const quadrant = gaussLegendre(QUADRANT_NODES);
  const polar = gaussLegendre(POLAR_NODES);
  for (let turn = 0; turn < 4; turn++)
    quadrant.nodes.forEach((node, i) => {
      const crowded = Math.tanh(CROWDING * node) / Math.tanh(CROWDING);
      const phi = 0.25 * Math.PI * (1 + crowded) + turn * 0.5 * Math.PI;
      const slope = CROWDING / (Math.tanh(CROWDING) * Math.cosh(CROWDING * node) ** 2);
      const phiWeight = 0.25 * Math.PI * quadrant.weights[i] * slope;
      const end = 0.5 * (0.5 * Math.PI + Math.atan2(sine * Math.cos(phi - azimuth), cosine));
      const span = Math.log(Math.tan(end)) - Math.log(LEAST_TANGENT);
      polar.nodes.forEach((place, k) => {
        const tangent = LEAST_TANGENT * Math.exp(0.5 * span * (place + 1));
        const cosH = 1 / Math.sqrt(1 + tangent * tangent);
        const sinH = tangent * cosH;
        const h = [sinH * Math.cos(phi), sinH * Math.sin(phi), cosH] as const;
        const dot = h[0] * incident[0] + h[1] * incident[1] + h[2] * incident[2];
        const out = h.map((number, axis) => 2 * dot * number - incident[axis]);
        const spread = 4 * dot * sinH * sinH * cosH;
        const weight = spread * (0.5 * span * polar.weights[k]) * phiWeight * out[2];
        if (weight > 0) {
          wi.push(...incident);
          wo.push(...out);
          weights.push(weight);
        }
      });
    });
}

/** Of each x the index of the last node that is not below it; both fall. */
function leftOf(nodes: readonly number[], x: Float64Array): number[] {
  return Array.from(x, (at) =>
    Math.min(nodes.filter((node) => node >= at).length - 1, nodes.length - 2),
  );
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
