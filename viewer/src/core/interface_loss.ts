/**
 * The share of light that a rough surface loses: it scatters light once, and what would meet a second
 * facet is lost. Of a coat over a white base, and of facets that reflect all light; see `core.albedos`
 * of Python.
 */

import { ALBEDOS, CHECKS, fresnel, FACETS as MIRRORS } from "../printed/formulas";
import { masking, mirrored } from "./facets";
import { gaussLegendre } from "./quadrature";

/** Nodes of means between two cosines. */
const { nodes: NODES, weights: WEIGHTS } = gaussLegendre(4);

/** Numbers that choose facets, dense where they are steep and on one side, and their weights. */
function facets([azimuths, heights]: readonly number[]) {
  return Array.from({ length: azimuths * heights }, (_, k) => {
    const row = Math.floor(k / azimuths);
    const root = (row + 0.5) / heights;
    const turn = ((k % azimuths) + ((row * 0.6180339887498949 + 0.5) % 1)) / azimuths;
    return { u1: 0.5 * turn, u2: 1 - root * root, weight: (2 * root) / (azimuths * heights) };
  });
}

/** Where some facets reflect totally, the share that does decides. */
const [COARSE, FINE] = [facets(ALBEDOS.COARSE), facets(ALBEDOS.FINE)];

/** Light that is reflected, and that passes, of the light from a direction. */
type Shares = readonly [reflected: number, passed: number];

function shares(alpha: number, eta: number, z: number): Shares {
  const wi = { x: Math.sqrt(1 - z * z), y: 0, z };
  let [reflected, passed] = [0, 0];
  for (const { u1, u2, weight } of eta < 1 ? FINE : COARSE) {
    const { cosine, height, unhidden } = mirrored(alpha, alpha, wi, u1, u2);
    const share = fresnel(cosine, eta, 0);
    reflected += weight * share * unhidden;
    const inside2 = 1 - (1 - cosine * cosine) / (eta * eta);
    if (inside2 <= 0) continue;
    const depth = z / eta - (cosine / eta - Math.sqrt(inside2)) * height;
    passed += weight * (1 - share) * masking(depth, alpha * alpha * (1 - depth * depth));
  }
  return [reflected, passed];
}

/** The cosine of the edge of total reflection; 0 if the medium is denser than the one above. */
function edgeOf(eta: number): number {
  return eta < 1 ? Math.sqrt(Math.max(1 - eta * eta, 1e-8)) : 0;
}

/**
 * The loss at the cosines of Python's tables, and its mean over diffuse light. The coordinate of the
 * cosines is their root, or follows the edge of total reflection.
 */
export interface Loss {
  readonly at: Float64Array;
  readonly mean: number;
  readonly edge: number;
}

const LAST = ALBEDOS.COSINES - 1;

/** Coordinate of the edge of total reflection. */
const EDGE = ALBEDOS.TOTAL_CELLS / LAST;

/** The cosine of a coordinate in [0, 1], and its derivative. */
function cosineAt(x: number, edge: number): readonly [cosine: number, slope: number] {
  if (x < EDGE && edge > 0) {
    const turn = (Math.PI * x) / EDGE;
    return [0.5 * edge * (1 - Math.cos(turn)), ((0.5 * Math.PI * edge) / EDGE) * Math.sin(turn)];
  }
  const start = edge > 0 ? EDGE : 0;
  const v = (x - start) / (1 - start);
  return [edge + (1 - edge) * v * v, (2 * (1 - edge) * v) / (1 - start)];
}

/** The loss at a cosine, linear between its nodes. */
export function lossAt({ at, edge }: Loss, cosine: number): number {
  const start = edge > 0 ? EDGE : 0;
  const x =
    cosine < edge
      ? (EDGE / Math.PI) * Math.acos(Math.min(Math.max(1 - (2 * cosine) / edge, -1), 1))
      : start + (1 - start) * Math.sqrt((cosine - edge) / (1 - edge));
  const place = Math.min(Math.max(x, 0), 1) * LAST;
  const first = Math.min(Math.floor(place), LAST - 1);
  return at[first] + (place - first) * (at[first + 1] - at[first]);
}

/** The shares at the nodes of the cosine. */
function tableOf(alpha: number, eta: number): Shares[] {
  return Array.from({ length: LAST + 1 }, (_, k) =>
    shares(alpha, eta, Math.max(cosineAt(k / LAST, edgeOf(eta))[0], 1e-5)),
  );
}

/** Mean, over diffuse light from a cell of the cosines on, of values that are linear between nodes. */
function meanOf(values: ArrayLike<number>, edge: number, start = 0): number {
  let [sum, light] = [0, 0];
  for (let k = start; k < LAST; k++)
    NODES.forEach((node, i) => {
      const share = 0.5 * (node + 1);
      const [cosine, slope] = cosineAt((k + share) / LAST, edge);
      const weight = cosine * slope * WEIGHTS[i];
      sum += weight * (values[k] + share * (values[k + 1] - values[k]));
      light += weight;
    });
  return sum / light;
}

/**
 * The loss of a surface of a width and an index relative to the medium above.
 *
 * @param mirrored share of the base's light that it mirrors; the other is Lambertian.
 */
export function surfaceLoss(alpha: number, eta: number, mirrored: number): Loss {
  if (eta === 1) return { at: new Float64Array(LAST + 1), mean: 0, edge: 0 };
  const below = edgeOf(1 / eta);
  const table = tableOf(alpha, 1 / eta);
  const [reflected, passed] = ([0, 1] as const).map((k) => {
    const values = table.map((share) => share[k]);
    const diffuse = meanOf(values, below);
    // Light that entered by a smooth interface, and that a mirror returns, is not reflected totally.
    const entered = below > 0 ? meanOf(values, below, ALBEDOS.TOTAL_CELLS) : diffuse;
    return diffuse + mirrored * (entered - diffuse);
  }) as [number, number];
  const inside = passed / (1 - reflected);
  const edge = edgeOf(eta);
  const at = Float64Array.from(tableOf(alpha, eta), (share) =>
    Math.max(1 - share[0] - inside * share[1], 0),
  );
  return { at, mean: meanOf(at, edge), edge };
}

/** The loss of facets that reflect all light, linear between widths as in Python's table. */
export function mirrorLoss(alpha: number): Loss {
  const least = Math.sqrt(CHECKS.MIN_ALPHA);
  const step = (1 - least) / (ALBEDOS.ROUGHNESSES - 1);
  const place = (Math.sqrt(alpha) - least) / step;
  const first = Math.min(Math.floor(place), ALBEDOS.ROUGHNESSES - 2);
  const [low, high] = [first, first + 1].map((node) =>
    tableOf((least + node * step) ** 2, MIRRORS.MIRROR),
  ) as [Shares[], Shares[]];
  const at = Float64Array.from(low, ([a], k) => 1 - a - (place - first) * (high[k][0] - a));
  return { at, mean: meanOf(at, 0), edge: 0 };
}
