/** GGX with separable Smith masking, Fresnel terms, and the phase function of media. */

import { dot, halfVector, normalised, type Vector, vector } from "./vector";

/** Reflectance of a smooth dielectric boundary; 1 under total reflection. */
export function dielectric(cosI: number, eta: number): number {
  const cosT2 = refractedCosine2(cosI, eta);
  if (cosT2 <= 0) {
    return 1;
  }
  const cosT = Math.sqrt(cosT2);
  const parallel = (eta * cosI - cosT) / (eta * cosI + cosT);
  const perpendicular = (cosI - eta * cosT) / (cosI + eta * cosT);
  return 0.5 * (parallel * parallel + perpendicular * perpendicular);
}

/** Cosine of the refracted angle; 0 under total reflection. */
export function refractedCosine(cosI: number, eta: number): number {
  return Math.sqrt(Math.max(refractedCosine2(cosI, eta), 0));
}

function refractedCosine2(cosI: number, eta: number): number {
  return 1 - (1 - cosI * cosI) / (eta * eta);
}

/** Normal distribution [1/sr] (Walter et al. 2007, eq. 33). */
function ggx(m: Vector, alpha: number): number {
  const alpha2 = alpha * alpha;
  const denominator = alpha2 * m.z * m.z + (m.x * m.x + m.y * m.y);
  return m.z > 0 ? alpha2 / (Math.PI * denominator * denominator) : 0;
}

/** Smith masking of a direction on either side (Walter et al. 2007, eq. 34). */
export function masking(w: Vector, alpha: number): number {
  const cos2 = w.z * w.z;
  const tan2 = (w.x * w.x + w.y * w.y) / cos2;
  return cos2 > 0 ? 2 / (1 + Math.sqrt(alpha * alpha * tan2 + 1)) : 0;
}

/** Density [1/sr] of `sampleVisibleNormal`; w.z > 0. */
export function visibleNormalDensity(w: Vector, m: Vector, alpha: number): number {
  return (masking(w, alpha) * ggx(m, alpha) * Math.max(dot(w, m), 0)) / w.z;
}

/** A facet normal that is visible from w, uniformly on a cap (Dupuy and Benyoub 2023). */
export function sampleVisibleNormal(w: Vector, alpha: number, u1: number, u2: number): Vector {
  const s = normalised(alpha * w.x, alpha * w.y, w.z);
  const z = (1 - u2) * (1 + s.z) - s.z;
  const phi = 2 * Math.PI * u1;
  const sine = Math.sqrt(Math.max(1 - z * z, 0));
  return normalised(
    alpha * (sine * Math.cos(phi) + s.x),
    alpha * (sine * Math.sin(phi) + s.y),
    Math.max(z + s.z, 0),
  );
}

/** The reflection BRDF [1/sr] for a reflectance of 1 (Walter et al. 2007, eq. 20). */
export function reflectionLobe(wi: Vector, wo: Vector, alpha: number): number {
  if (!(wi.z > 0 && wo.z > 0)) {
    return 0;
  }
  const d = ggx(halfVector(wi, wo), alpha);
  return (d * masking(wi, alpha) * masking(wo, alpha)) / (4 * wi.z * wo.z);
}

/** A direction of the density cos / pi. */
export function sampleCosine(u1: number, u2: number): Vector {
  const radius = Math.sqrt(u1);
  const phi = 2 * Math.PI * u2;
  return vector(radius * Math.cos(phi), radius * Math.sin(phi), Math.sqrt(Math.max(1 - u1, 0)));
}

/** Henyey and Greenstein's phase function [1/sr], which is its own density. */
export function phase(cosine: number, g: number): number {
  const base = 1 + g * g - 2 * g * cosine;
  return ((0.25 / Math.PI) * (1 - g * g)) / (base * Math.sqrt(base));
}

/** The cosine of a scattered direction with that density, by inversion. */
export function samplePhaseCosine(g: number, u: number): number {
  const x = 2 * u - 1;
  if (Math.abs(g) < 1e-3) {
    // The first-order expansion in g avoids 0 / 0 near isotropy.
    return clampedCosine(x + 1.5 * g * (1 - x * x));
  }
  const s = (1 - g * g) / (1 + g * x);
  return clampedCosine((1 + g * g - s * s) / (2 * g));
}

function clampedCosine(x: number): number {
  return Math.min(Math.max(x, -1), 1);
}
