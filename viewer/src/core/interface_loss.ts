/**
 * The share of light that a rough surface loses: it scatters light once, and what would meet a second
 * facet is lost. Of a coat over a white base, and of facets that reflect all light; see `core.albedos`
 * of Python.
 */

import { ALBEDOS, CHECKS, fresnel, FACETS as MIRRORS } from "./formulas";
import { gaussLegendre } from "./quadrature";

/** Nodes of the quadrature over visible facets: of their azimuth, and of their height. */
const AZIMUTHS = 20;
const HEIGHTS = 40;

/** Nodes of means over a hemisphere, on either side of the edge of total reflection. */
const { nodes: NODES, weights: WEIGHTS } = gaussLegendre(16);

/** Azimuths [rad] and heights in (0, 1) of facets, dense where they are steep, and their weights. */
const FACETS = Array.from({ length: AZIMUTHS * HEIGHTS }, (_, k) => {
  const row = Math.floor(k / AZIMUTHS);
  const root = (row + 0.5) / HEIGHTS;
  const turn = ((k % AZIMUTHS) + ((row * 0.6180339887498949 + 0.5) % 1)) / AZIMUTHS;
  return { turn: Math.PI * turn, height: root * root, weight: (2 * root) / (AZIMUTHS * HEIGHTS) };
});

/** Light that is reflected, and that passes, of the light from a direction. */
type Shares = readonly [reflected: number, passed: number];

/** By facets that are visible from the direction, uniformly on a cap (Dupuy and Benyoub 2023). */
function shares(alpha: number, eta: number, cosine: number): Shares {
  const sine = Math.sqrt(1 - cosine * cosine);
  const size = Math.hypot(alpha * sine, cosine);
  const [wideX, wideZ] = [(alpha * sine) / size, cosine / size];
  let [reflected, passed] = [0, 0];
  for (const { turn, height, weight } of FACETS) {
    const up = height * (1 + wideZ) - wideZ;
    const radius = Math.sqrt(Math.max(1 - up * up, 0));
    const [x, z] = [alpha * (radius * Math.cos(turn) + wideX), up + wideZ];
    const length = Math.hypot(x, alpha * radius * Math.sin(turn), z);
    const [facetX, facetZ] = [x / length, z / length];
    const toFacet = sine * facetX + cosine * facetZ;
    const share = fresnel(Math.min(toFacet, 1), eta, 0);
    const inside2 = 1 - (1 - toFacet * toFacet) / (eta * eta);
    const mirrored = 2 * toFacet * facetZ - cosine;
    const refracted = (toFacet / eta - Math.sqrt(Math.max(inside2, 0))) * facetZ - cosine / eta;
    if (mirrored > 0) reflected += weight * share * masking(alpha, mirrored);
    if (refracted < 0 && inside2 > 0) passed += weight * (1 - share) * masking(alpha, refracted);
  }
  return [reflected, passed];
}

/** Smith's term of a direction (Walter et al. 2007, equation 34). */
function masking(alpha: number, cosine: number): number {
  const cos2 = cosine * cosine;
  return 2 / (1 + Math.sqrt(1 + (alpha * alpha * (1 - cos2)) / cos2));
}

/** Means of the shares over diffuse light of cosines from `low` to 1, relative to its light there. */
function means(alpha: number, eta: number, low: number): Shares {
  let [reflected, passed] = [0, 0];
  // The edge of total reflection, beyond which shares change with the root of the distance
  const edge = eta < 1 ? Math.sqrt(1 - eta * eta) : 0;
  for (const [from, to] of [
    [0, edge],
    [edge, 1],
  ] as const) {
    if (to <= low) continue;
    NODES.forEach((node, k) => {
      const root = 0.5 * (node + 1);
      const cosine = from + (to - from) * root * root;
      const weight = 2 * cosine * (to - from) * root * WEIGHTS[k];
      const [one, other] = shares(alpha, eta, cosine);
      reflected += weight * one;
      passed += weight * other;
    });
  }
  return [reflected / (1 - low * low), passed / (1 - low * low)];
}

/** Cosines at which losses are known: those of Python's tables, whose roots have equal distances. */
export const COSINES = Float32Array.from({ length: ALBEDOS.COSINES }, (_, k) =>
  Math.max((k / (ALBEDOS.COSINES - 1)) ** 2, 1e-5),
);

/** The loss at cosines, and its mean over diffuse light. */
export interface Loss {
  readonly at: Float64Array;
  readonly mean: number;
}

/**
 * The loss of a surface of a width and an index relative to the medium above.
 *
 * @param mirrored share of the base's light that it mirrors; the other is Lambertian.
 */
export function surfaceLoss(
  alpha: number,
  eta: number,
  mirrored: number,
  cosines: Float32Array,
): Loss {
  const at = new Float64Array(cosines.length);
  if (eta === 1) return { at, mean: 0 };
  // Light that entered by a smooth interface, and that a mirror returns, is not reflected totally.
  const edge = eta > 1 ? Math.sqrt(1 - 1 / (eta * eta)) : 0;
  const [diffuse, entered] = [0, edge].map((low) => means(alpha, 1 / eta, low));
  const mixed = (k: 0 | 1) => diffuse[k] + mirrored * (entered[k] - diffuse[k]);
  const inside = mixed(1) / (1 - mixed(0));
  const lostOf = ([reflected, passed]: Shares) => 1 - reflected - inside * passed;
  cosines.forEach((cosine, k) => {
    at[k] = Math.max(lostOf(shares(alpha, eta, cosine)), 0);
  });
  return { at, mean: lostOf(means(alpha, eta, 0)) };
}

/** The loss at `COSINES` of facets that reflect all light, linear between widths as in Python's table. */
export function mirrorLoss(alpha: number): Loss {
  const least = Math.sqrt(CHECKS.MIN_ALPHA);
  const step = (1 - least) / (ALBEDOS.ROUGHNESSES - 1);
  const place = (Math.sqrt(alpha) - least) / step;
  const first = Math.min(Math.floor(place), ALBEDOS.ROUGHNESSES - 2);
  const [low, high] = [first, first + 1].map((node) => {
    const width = (least + node * step) ** 2;
    return Float64Array.from(COSINES, (cosine) => 1 - shares(width, MIRRORS.MIRROR, cosine)[0]);
  }) as [Float64Array, Float64Array];
  const at = low.map((loss, k) => loss + (place - first) * (high[k]! - loss));
  // The mean of what is linear in the root x of the cosine, by the integral of 4 x^3
  const last = at.length - 1;
  let mean = 0;
  for (let k = 0; k < last; k++)
    NODES.forEach((node, i) => {
      const share = 0.5 * (node + 1);
      const root = (k + share) / last;
      const loss = at[k]! + share * (at[k + 1]! - at[k]!);
      mean += (2 * root ** 3 * WEIGHTS[i]! * loss) / last;
    });
  return { at, mean };
}
