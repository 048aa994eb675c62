/** Quadrature: Gauss's rules, and one over the hemisphere that resolves any GGX-like lobe. */

import { QUADRATURE, type Vector } from "./formulas";

/** Nodes and weights of a one-dimensional rule. */
export interface Rule {
  readonly nodes: Float64Array;
  readonly weights: Float64Array;
}

const legendre = new Map<number, Rule>();

/** Gauss and Legendre's rule on [-1, 1]. */
export function gaussLegendre(count: number): Rule {
  let found = legendre.get(count);
  if (!found) {
    const beside = Float64Array.from({ length: count }, (_, k) => 1 / Math.sqrt(4 - (k + 1) ** -2));
    const { nodes, weights } = ruleOfMatrix(new Float64Array(count), beside, -1);
    found = { nodes, weights: weights.map((weight) => 2 * weight) };
    legendre.set(count, found);
  }
  return found;
}

/**
 * Gauss's rule of a symmetric tridiagonal matrix (Golub and Welsch 1969), its weights of sum 1.
 *
 * The nodes are the roots of the last of the orthogonal polynomials that the matrix defines; roots
 * of each lie between those of the one before it.
 *
 * @param diagonal the matrix's diagonal; beside: the elements beside it, and one that is not used.
 * @param least the nodes lie between this and 1.
 */
export function ruleOfMatrix(diagonal: Float64Array, beside: Float64Array, least: number): Rule {
  let nodes: number[] = [];
  for (let degree = 1; degree <= diagonal.length; degree++) {
    const edges = [least, ...nodes, 1];
    const at = (x: number) => polynomial(diagonal, beside, degree, x);
    // The polynomial rises at its greatest root, and in turn.
    nodes = edges.slice(1).map((edge, i) => {
      return rootBetween(edges[i], edge, (degree - i) % 2 === 1, at);
    });
  }
  const weights = nodes.map((x) => 1 / polynomial(diagonal, beside, nodes.length, x).squares);
  return { nodes: Float64Array.from(nodes), weights: Float64Array.from(weights) };
}

interface PolynomialValue {
  readonly value: number;
  readonly slope: number;
  /** Sum of the squares of the polynomials of lower degrees. */
  readonly squares: number;
}

/** The orthonormal polynomial of a degree by its recurrence; scaled, which keeps its roots. */
function polynomial(
  diagonal: Float64Array,
  beside: Float64Array,
  degree: number,
  x: number,
): PolynomialValue {
  let [previous, value, previousSlope, slope, squares] = [0, 1, 0, 0, 0];
  for (let k = 0; k < degree; k++) {
    squares += value * value;
    const [below, above] = [k > 0 ? beside[k - 1] : 0, beside[k] || 1];
    const next = ((x - diagonal[k]) * value - below * previous) / above;
    const nextSlope = (value + (x - diagonal[k]) * slope - below * previousSlope) / above;
    [previous, value, previousSlope, slope] = [value, next, slope, nextSlope];
  }
  return { value, slope, squares };
}

/** The only root between two numbers, by Newton's method within a shrinking bracket. */
function rootBetween(
  low: number,
  high: number,
  isRising: boolean,
  at: (x: number) => PolynomialValue,
): number {
  let x = 0.5 * (low + high);
  for (let round = 0; round < 100; round++) {
    const { value, slope } = at(x);
    if (value > 0 === isRising) high = x;
    else low = x;
    const step = x - value / slope;
    const next = step > low && step < high ? step : 0.5 * (low + high);
    if (Math.abs(next - x) <= 1e-16) break;
    x = next;
  }
  return x;
}

const { POLAR_NODES, AZIMUTH_NODES, MIN_TANGENT } = QUADRATURE;

const polar = gaussLegendre(POLAR_NODES);

/** Directions (M, 3), and weights (M) of f, cosine not included. */
export interface DirectionRule {
  readonly wo: Float64Array;
  readonly weights: Float64Array;
}

/** Room for a number of directions. */
export function emptyRule(count: number): DirectionRule {
  return { wo: new Float64Array(3 * count), weights: new Float64Array(count) };
}

/**
 * Put directions and weights for wi, from half vectors at an azimuth, at place `first` and after.
 *
 * The variable is logarithmic in tan theta_h, and its range ends at the horizon; see Python's
 * `core.quadrature`.
 */
export function addHalfVectors(
  { wo, weights }: DirectionRule,
  first: number,
  wi: Vector,
  phi: number,
  phiWeight: number,
  polar: Rule,
  leastTangent: number,
): void {
  const [cosPhi, sinPhi, start] = [Math.cos(phi), Math.sin(phi), Math.log(leastTangent)];
  const end = 0.5 * (0.5 * Math.PI + Math.atan2(wi.x * cosPhi + wi.y * sinPhi, wi.z));
  const span = Math.max(Math.log(Math.tan(end)) - start, 0);
  for (let k = 0; k < polar.nodes.length; k++) {
    const tangent = Math.exp(start + 0.5 * span * (polar.nodes[k] + 1));
    const cosH = 1 / Math.sqrt(1 + tangent * tangent);
    const sinH = tangent * cosH;
    const [x, y] = [sinH * cosPhi, sinH * sinPhi];
    const dot = wi.x * x + wi.y * y + wi.z * cosH;
    const at = first + k;
    wo[3 * at] = 2 * dot * x - wi.x;
    wo[3 * at + 1] = 2 * dot * y - wi.y;
    wo[3 * at + 2] = 2 * dot * cosH - wi.z;
    weights[at] = 4 * dot * sinH * sinH * cosH * (0.5 * span * polar.weights[k]) * phiWeight;
  }
}

/**
 * A rule for wi = (sin, 0, cos): the sum of f cos_o weights integrates f cos_o.
 *
 * Nodes lie on one side of the plane of incidence, about which f must be symmetric. For anisotropic
 * f they are twice as dense: at the azimuth of the tangent, f is symmetric as well.
 */
export function halfVectorRule(cosine: number, isAnisotropic: boolean): DirectionRule {
  const wi = { x: Math.sqrt(Math.max(1 - cosine * cosine, 0)), y: 0, z: cosine };
  const { nodes, weights } = gaussLegendre(AZIMUTH_NODES * (isAnisotropic ? 2 : 1));
  const rule = emptyRule(2 * nodes.length * POLAR_NODES);
  for (let i = 0; i < 2 * nodes.length; i++) {
    const quarter = 0.25 * Math.PI * (nodes[i % nodes.length] + 1);
    const phi = i < nodes.length ? quarter : Math.PI - quarter;
    const phiWeight = 0.5 * Math.PI * weights[i % nodes.length]; // both sides
    addHalfVectors(rule, i * POLAR_NODES, wi, phi, phiWeight, polar, MIN_TANGENT);
  }
  return rule;
}
