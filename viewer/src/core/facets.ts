/** Light that rough surfaces scatter once, by their visible facets. */

import { type Vector, visibleNormal } from "../printed/formulas";

/**
 * Smith's term of a direction; 0 below the surface (Walter et al. 2007, equation 34).
 *
 * @param stretched2 square of its part along the surface, multiplied by the widths.
 */
export function masking(z: number, stretched2: number): number {
  return z > 0 ? (2 * z) / (z + Math.sqrt(z * z + stretched2)) : 0;
}

/**
 * Light from wi that a visible facet mirrors: the cosine to the facet, the facet's own, and the
 * share that no other facet hides.
 *
 * @param u1, u2 in [0, 1): they choose the facet.
 */
export function mirrored(u: number, v: number, wi: Vector, u1: number, u2: number) {
  const facet = visibleNormal(u, v, wi.x, wi.y, wi.z, u1, u2);
  const size = Math.hypot(facet.x, facet.y, facet.z);
  const dot = wi.x * facet.x + wi.y * facet.y + wi.z * facet.z;
  const cosine = Math.min(Math.max(dot / size, 1e-6), 1);
  const height = facet.z / size;
  const twice = (2 * cosine) / size;
  const [along, across] = [u * (twice * facet.x - wi.x), v * (twice * facet.y - wi.y)];
  const unhidden = masking(2 * cosine * height - wi.z, along * along + across * across);
  return { cosine, height, unhidden };
}
