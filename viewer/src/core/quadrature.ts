/** Quadrature: Gauss's rule, and one over the hemisphere that resolves any GGX-like lobe. */

import type { Vector } from "../printed/formulas";

/** Nodes and weights of Gauss and Legendre's rule on [-1, 1], by Newton's method. */
export function gaussLegendre(count: number) {
  const [nodes, weights] = [new Float64Array(count), new Float64Array(count)];
  nodes.forEach((_, i) => {
    let x = Math.cos((Math.PI * (i + 0.75)) / (count + 0.5));
    for (let round = 0; round < 8; round++) {
      let [before, value] = [1, x];
      for (let k = 2; k <= count; k++)
        [before, value] = [value, ((2 * k - 1) * x * value - (k - 1) * before) / k];
      const slope = (count * (x * value - before)) / (x * x - 1);
      x -= value / slope;
      weights[i] = 2 / ((1 - x * x) * slope * slope);
    }
    nodes[i] = x;
  });
  return { nodes, weights };
}

/**
 * Numbers of nodes of the slope of the half vector and of the azimuth, for a quadrant; how strongly
 * these crowd at its ends, and the least slope.
 */
export type RuleSize = readonly [slopes: number, azimuths: number, crowding: number, least: number];

/**
 * The rule of f cos_o for the direction wi: directions wo (M, 3) above the horizon, and weights (M)
 * of f, the cosine included.
 *
 * The variables are ln tan theta_h, up to the horizon, and the azimuth of the half vector; see
 * Python's `core.quadrature`.
 *
 * @param sides 1: f is symmetric about the xz plane, in which wi lies; 2: it is not.
 */
export function directionRule(
  wi: Vector,
  sides: 1 | 2,
  [slopes, azimuths, crowding, least]: RuleSize,
) {
  const [turns, steps] = [gaussLegendre(azimuths), gaussLegendre(slopes)];
  const start = Math.log(least);
  const [wo, weights]: [number[], number[]] = [[], []];
  for (let i = 0; i < 2 * sides * azimuths; i++) {
    const crowded = crowding * turns.nodes[i % azimuths];
    const turn = Math.floor(i / azimuths) + 0.5 * (Math.tanh(crowded) / Math.tanh(crowding) + 1);
    const phi = 0.5 * Math.PI * turn;
    const crowd = crowding / (Math.tanh(crowding) * Math.cosh(crowded) ** 2);
    const share = (0.5 * Math.PI * turns.weights[i % azimuths] * crowd) / sides;
    const [cosPhi, sinPhi] = [Math.cos(phi), Math.sin(phi)];
    const end = 0.5 * (0.5 * Math.PI + Math.atan2(wi.x * cosPhi + wi.y * sinPhi, wi.z));
    const span = Math.max(Math.log(Math.tan(end)) - start, 0);
    for (let k = 0; k < slopes; k++) {
      const tangent = Math.exp(start + 0.5 * span * (steps.nodes[k] + 1));
      const cosH = 1 / Math.sqrt(1 + tangent * tangent);
      const sinH = tangent * cosH;
      const [x, y] = [sinH * cosPhi, sinH * sinPhi];
      const dot = wi.x * x + wi.y * y + wi.z * cosH;
      const cosine = 2 * dot * cosH - wi.z;
      const weight = 2 * span * steps.weights[k] * share * dot * sinH * sinH * cosH * cosine;
      if (!(cosine > 0 && weight > 0)) continue;
      wo.push(2 * dot * x - wi.x, 2 * dot * y - wi.y, cosine);
      weights.push(weight);
    }
  }
  return { wo, weights };
}
