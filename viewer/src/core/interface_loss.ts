/**
 * The share of light that a rough surface loses: it scatters light once, and what would meet a second
 * facet is lost. Of a coat over a white base, and of facets that reflect all light; see `core.albedos`
 * of Python.
 */

import { masking, mirrored } from "./facets";
import { ALBEDOS, CHECKS, fresnel, FACETS as MIRRORS } from "./formulas";
import { gaussLegendre } from "./quadrature";

/** Nodes of the quadrature over visible facets: of their azimuth, and of their height. */
const AZIMUTHS = 20;
const HEIGHTS = 40;
/** Nodes of means over a hemisphere, on either side of the edge of total reflection. */
const { nodes: NODES, weights: WEIGHTS } = gaussLegendre(16);

/** Numbers that choose facets, dense where they are steep and on one side, and their weights. */
const FACETS = Array.from({ length: AZIMUTHS * HEIGHTS }, (_, k) => {
  const row = Math.floor(k / AZIMUTHS);
  const root = (row + 0.5) / HEIGHTS;
  const turn = ((k % AZIMUTHS) + ((row * 0.6180339887498949 + 0.5) % 1)) / AZIMUTHS;
  return { u1: 0.5 * turn, u2: 1 - root * root, weight: (2 * root) / (AZIMUTHS * HEIGHTS) };
});

/** Light that is reflected, and that passes, of the light from a direction. */
type Shares = readonly [reflected: number, passed: number];

function shares(alpha: number, eta: number, z: number): Shares {
  const wi = { x: Math.sqrt(1 - z * z), y: 0, z };
  let [reflected, passed] = [0, 0];
  for (const { u1, u2, weight } of FACETS) {
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

/**
 * Means of the shares over diffuse light, relative to it.
 *
 * @param entered only of the light that a smooth surface does not reflect totally.
 */
function means(alpha: number, eta: number, entered: boolean): Shares {
  // The edge of total reflection, beyond which shares change with the root of the distance
  const edge = eta < 1 ? Math.sqrt(1 - eta * eta) : 0;
  let [reflected, passed, light] = [0, 0, 0];
  for (const [from, to] of [[edge, 1] as const, ...(entered ? [] : [[0, edge] as const])]) {
    NODES.forEach((node, k) => {
      const root = 0.5 * (node + 1);
      const cosine = from + (to - from) * root * root;
      const weight = 2 * cosine * (to - from) * root * WEIGHTS[k];
      const [one, other] = shares(alpha, eta, cosine);
      reflected += weight * one;
      passed += weight * other;
      light += weight;
    });
  }
  return [reflected / light, passed / light];
}

/** Cosines at which losses are known: those of Python's tables, whose roots have equal distances. */
export const COSINES = Float32Array.from({ length: ALBEDOS.COSINES }, (_, k) =>
  Math.max((k / (ALBEDOS.COSINES - 1)) ** 2, 1e-5),
);

/** The loss at `COSINES`, and its mean over diffuse light. */
export interface Loss {
  readonly at: Float64Array;
  readonly mean: number;
}

/** Of losses linear in the root x of the cosine: the mean is the integral of 4 x^3. */
function lossOf(at: Float64Array): Loss {
  const last = at.length - 1;
  let mean = 0;
  for (let k = 0; k < last; k++)
    NODES.forEach((node, i) => {
      const share = 0.5 * (node + 1);
      const loss = at[k] + share * (at[k + 1] - at[k]);
      mean += (2 * ((k + share) / last) ** 3 * WEIGHTS[i] * loss) / last;
    });
  return { at, mean };
}

/**
 * The loss of a surface of a width and an index relative to the medium above.
 *
 * @param mirrored share of the base's light that it mirrors; the other is Lambertian.
 */
export function surfaceLoss(alpha: number, eta: number, mirrored: number): Loss {
  if (eta === 1) return { at: new Float64Array(COSINES.length), mean: 0 };
  // Light that entered by a smooth interface, and that a mirror returns, is not reflected totally.
  const [diffuse, entered] = [false, true].map((entered) => means(alpha, 1 / eta, entered));
  const mixed = (k: 0 | 1) => diffuse[k] + mirrored * (entered[k] - diffuse[k]);
  const inside = mixed(1) / (1 - mixed(0));
  return lossOf(
    Float64Array.from(COSINES, (cosine) => {
      const [reflected, passed] = shares(alpha, eta, cosine);
      return Math.max(1 - reflected - inside * passed, 0);
    }),
  );
}

/** The loss of facets that reflect all light, linear between widths as in Python's table. */
export function mirrorLoss(alpha: number): Loss {
  const least = Math.sqrt(CHECKS.MIN_ALPHA);
  const step = (1 - least) / (ALBEDOS.ROUGHNESSES - 1);
  const place = (Math.sqrt(alpha) - least) / step;
  const first = Math.min(Math.floor(place), ALBEDOS.ROUGHNESSES - 2);
  const [low, high] = [first, first + 1].map((node) => {
    const width = (least + node * step) ** 2;
    return Float64Array.from(COSINES, (cosine) => 1 - shares(width, MIRRORS.MIRROR, cosine)[0]);
  }) as [Float64Array, Float64Array];
  return lossOf(low.map((loss, k) => loss + (place - first) * (high[k] - loss)));
}
