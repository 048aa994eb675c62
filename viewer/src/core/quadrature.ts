/** Quadrature: Gauss's rules, and one over the hemisphere that resolves any GGX-like lobe. */

import { QUADRATURE } from "./formulas";

/** Nodes and weights of a one-dimensional rule. */
export interface Rule {
  readonly nodes: Float64Array;
  readonly weights: Float64Array;
}

/** Gauss and Legendre's rule on [-1, 1], by Newton's method. */
export function gaussLegendre(count: number): Rule {
  const nodes = new Float64Array(count);
  const weights = new Float64Array(count);
  for (let i = 0; i < count; i++) {
    let x = -Math.cos((Math.PI * (i + 0.75)) / (count + 0.5));
    let slope = 1;
    for (let round = 0; round < 50; round++) {
      let [previous, value] = [1, x];
      for (let k = 2; k <= count; k++) {
        [previous, value] = [value, ((2 * k - 1) * x * value - (k - 1) * previous) / k];
      }
      slope = (count * (x * value - previous)) / (x * x - 1);
      const change = value / slope;
      x -= change;
      if (Math.abs(change) < 1e-15) {
        break;
      }
    }
    nodes[i] = x;
    weights[i] = 2 / ((1 - x * x) * slope * slope);
  }
  return { nodes, weights };
}

/**
 * Gauss's rule of a symmetric tridiagonal matrix (Golub and Welsch 1969): its eigenvalues, and the
 * squares of the first components of its eigenvectors, in ascending order. By the QL algorithm with
 * implicit shifts.
 *
 * @param diagonal its diagonal, which is overwritten.
 * @param beside the elements beside the diagonal, as many as the diagonal's, the last one unused;
 *   overwritten.
 */
export function ruleOfMatrix(diagonal: Float64Array, beside: Float64Array): Rule {
  const n = diagonal.length;
  const firsts = new Float64Array(n);
  firsts[0] = 1;
  beside[n - 1] = 0;
  for (let l = 0; l < n; l++) {
    for (let round = 0; round < 100; round++) {
      let m = l;
      while (m < n - 1 && !isNegligible(diagonal, beside, m)) {
        m++;
      }
      if (m === l) {
        break;
      }
      rotate(diagonal, beside, firsts, l, m);
    }
  }
  const order = Array.from(diagonal.keys()).sort((a, b) => diagonal[a] - diagonal[b]);
  return {
    nodes: Float64Array.from(order, (k) => diagonal[k]),
    weights: Float64Array.from(order, (k) => firsts[k] * firsts[k]),
  };
}

function isNegligible(diagonal: Float64Array, beside: Float64Array, m: number): boolean {
  const size = Math.abs(diagonal[m]) + Math.abs(diagonal[m + 1]);
  return Math.abs(beside[m]) <= Number.EPSILON * size;
}

/** One implicit QL sweep over rows l to m (Press et al. 2007, section 11.4). */
function rotate(
  diagonal: Float64Array,
  beside: Float64Array,
  firsts: Float64Array,
  l: number,
  m: number,
): void {
  let g = (diagonal[l + 1] - diagonal[l]) / (2 * beside[l]);
  let r = Math.hypot(g, 1);
  g = diagonal[m] - diagonal[l] + beside[l] / (g + (g < 0 ? -r : r));
  let s = 1;
  let c = 1;
  let p = 0;
  for (let i = m - 1; i >= l; i--) {
    const f = s * beside[i];
    const b = c * beside[i];
    r = Math.hypot(f, g);
    beside[i + 1] = r;
    if (r === 0) {
      diagonal[i + 1] -= p;
      beside[m] = 0;
      return;
    }
    s = f / r;
    c = g / r;
    g = diagonal[i + 1] - p;
    r = (diagonal[i] - g) * s + 2 * c * b;
    p = s * r;
    diagonal[i + 1] = g + p;
    g = c * r - b;
    const above = firsts[i + 1];
    firsts[i + 1] = s * firsts[i] + c * above;
    firsts[i] = c * firsts[i] - s * above;
  }
  diagonal[l] -= p;
  beside[l] = g;
  beside[m] = 0;
}

const { POLAR_NODES, AZIMUTH_NODES, MIN_TANGENT } = QUADRATURE;

const polar = gaussLegendre(POLAR_NODES);

/** Directions (M, 3), and weights (M) of f, cosine not included. */
export interface DirectionRule {
  readonly wo: Float64Array;
  readonly weights: Float64Array;
}

/**
 * A rule for wi = (sin, 0, cos): the sum of f cos_o weights integrates f cos_o.
 *
 * Nodes lie on one side of the plane of incidence, about which f must be symmetric. For anisotropic
 * f they are twice as dense: at the azimuth of the tangent, f is symmetric as well.
 *
 * The variable is the half vector, logarithmic in tan theta_h, and its range ends at the horizon;
 * see Python's `geometry.quadrature`.
 */
export function halfVectorRule(cosine: number, isAnisotropic: boolean): DirectionRule {
  const half = AZIMUTH_NODES * (isAnisotropic ? 2 : 1);
  const azimuths = gaussLegendre(half);
  const c = cosine;
  const s = Math.sqrt(Math.max(1 - c * c, 0));
  const count = 2 * half * POLAR_NODES;
  const wo = new Float64Array(3 * count);
  const weights = new Float64Array(count);
  const start = Math.log(MIN_TANGENT);
  let at = 0;
  for (let i = 0; i < 2 * half; i++) {
    const quarter = 0.25 * Math.PI * (azimuths.nodes[i % half] + 1);
    const phi = i < half ? quarter : Math.PI - quarter;
    const phiWeight = 0.5 * Math.PI * azimuths.weights[i % half]; // both sides
    const cosPhi = Math.cos(phi);
    const sinPhi = Math.sin(phi);
    const end = 0.5 * (0.5 * Math.PI + Math.atan2(s * cosPhi, c));
    const span = Math.max(Math.log(Math.tan(end)) - start, 0);
    for (let k = 0; k < POLAR_NODES; k++, at++) {
      const tangent = Math.exp(start + 0.5 * span * (polar.nodes[k] + 1));
      const cosH = 1 / Math.sqrt(1 + tangent * tangent);
      const sinH = tangent * cosH;
      const hx = sinH * cosPhi;
      const dot = s * hx + c * cosH;
      wo[3 * at] = 2 * dot * hx - s;
      wo[3 * at + 1] = 2 * dot * sinH * sinPhi;
      wo[3 * at + 2] = 2 * dot * cosH - c;
      weights[at] = 4 * dot * sinH * sinH * cosH * (0.5 * span * polar.weights[k]) * phiWeight;
    }
  }
  return { wo, weights };
}
