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
import { last } from "./layers";
import { addHalfVectors, emptyRule, gaussLegendre } from "./quadrature";

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

/** The nodes of a rule: cosines of wi at each of its azimuths, and what belongs to each wi. */
interface Nodes {
  readonly wi: number[];
  readonly wo: number[];
  readonly weights: number[];
  readonly bounds: number[];
  readonly cosines: readonly number[];
  readonly azimuths: number;
}

/** The rule of codes of one GGX width or two. */
export function albedoRule(widths: Widths): AlbedoRule {
  const { wi, wo, weights, bounds, cosines, azimuths } =
    widths === 1 ? isotropicNodes() : anisotropicNodes();
  const nodes = cosines.map((cosine) => Math.log(cosine + COSINE_OFFSET));
  const steps = Array.from(
    { length: INTERPOLATED_COSINES },
    (_, d) => d / (INTERPOLATED_COSINES - 1),
  );
  const between = steps.map((step) => nodes[0] + (last(nodes) - nodes[0]) * step);
  const blocks = Array.from({ length: azimuths }, (_, block) => block * nodes.length);
  const [incident, out] = [Float32Array.from(wi), Float32Array.from(wo)];
  return {
    pairs: Pairs.of(incident, out, widths),
    wi: incident,
    wo: out,
    weights: Float64Array.from(weights),
    bounds: [...bounds, weights.length],
    cosines: Float64Array.from(
      blocks.flatMap(() => between.map((x) => Math.exp(x) - COSINE_OFFSET)),
    ),
    polynomial: Float64Array.from(
      blocks.flatMap((own) =>
        between.flatMap((x) => blocks.flatMap((other) => lagrange(nodes, x, own === other))),
      ),
    ),
    left: blocks.flatMap((start) => between.map((x) => start + leftOf(nodes, x))),
    angles: Float64Array.from(blocks.flatMap(() => cosines)),
  };
}

/** Those of the table. */
function isotropicNodes(): Nodes {
  const lines = table.split("\n").filter((line) => line && !line.startsWith("#"));
  const rows = lines.map((line) => line.split(",").map(Number));
  const bounds = rows.flatMap((row, i) => (row[0] === rows[i - 1]?.[0] ? [] : [i]));
  return {
    wi: rows.flatMap(([cosine]) => [Math.sqrt(1 - cosine * cosine), 0, cosine]),
    wo: rows.flatMap((row) => row.slice(1, 4)),
    weights: rows.map((row) => row[4]),
    bounds,
    cosines: bounds.map((i) => rows[i][0]),
    azimuths: 1,
  };
}

/** Half vectors logarithmic in tan theta_h, dense in azimuth near the xz and the yz plane. */
function anisotropicNodes(): Nodes {
  const quadrant = gaussLegendre(QUADRANT_NODES);
  const polar = gaussLegendre(POLAR_NODES);
  const nodes = { wi: [] as number[], wo: [] as number[], weights: [] as number[] };
  const bounds: number[] = [];
  for (const azimuth of AZIMUTHS)
    for (const z of ANISOTROPIC_COSINES) {
      bounds.push(nodes.weights.length);
      const sine = Math.sqrt(1 - z * z);
      const wi = { x: sine * Math.cos(azimuth), y: sine * Math.sin(azimuth), z };
      const found = emptyRule(4 * QUADRANT_NODES * POLAR_NODES);
      for (let turn = 0; turn < 4; turn++)
        quadrant.nodes.forEach((node, i) => {
          const crowded = Math.tanh(CROWDING * node) / Math.tanh(CROWDING);
          const phi = 0.25 * Math.PI * (1 + crowded) + turn * 0.5 * Math.PI;
          const slope = CROWDING / (Math.tanh(CROWDING) * Math.cosh(CROWDING * node) ** 2);
          const weight = 0.25 * Math.PI * quadrant.weights[i] * slope;
          const first = (turn * QUADRANT_NODES + i) * POLAR_NODES;
          addHalfVectors(found, first, wi, phi, weight, polar, LEAST_TANGENT);
        });
      found.weights.forEach((weight, i) => {
        const [x, y, cosine] = found.wo.slice(3 * i, 3 * i + 3);
        if (!(weight * cosine > 0)) return;
        nodes.wi.push(wi.x, wi.y, wi.z);
        nodes.wo.push(x, y, cosine);
        nodes.weights.push(weight * cosine);
      });
    }
  return { ...nodes, bounds, cosines: ANISOTROPIC_COSINES, azimuths: AZIMUTHS.length };
}

/** The index of the last node that is not below x; the nodes fall. */
function leftOf(nodes: readonly number[], x: number): number {
  return Math.min(nodes.filter((node) => node >= x).length - 1, nodes.length - 2);
}

/** The row (N) from values at nodes to that of their polynomial at x; zero if it is of no use. */
function lagrange(nodes: readonly number[], x: number, isUsed: boolean): number[] {
  return nodes.map((node, column) => {
    if (!isUsed) return 0;
    const others = nodes.filter((_, other) => other !== column);
    return others.reduce((product, other) => (product * (x - other)) / (node - other), 1);
  });
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
