/**
 * The rough dielectric interface: a GGX surface between two media (Walter et al. 2007).
 *
 * Functions take directions in a frame whose +z side holds `wi`, and `eta`, the index of the far
 * side relative to it. Transmission is in flux convention, without the scaling of radiance, so that
 * a stack seen from outside is reciprocal. At index 1 there is no interface: samples are the opposite
 * of wi with weight 1, and functions of two directions give 0.
 */

import {
  dielectric,
  masking,
  reflectionLobe,
  refractedCosine,
  sampleVisibleNormal,
  visibleNormalDensity,
} from "./microfacet";
import { dot, halfVector, negated, normalised, reflected, refracted, type Vector } from "./vector";

/** A value [1/sr] and the density [1/sr] with which sampling finds its direction. */
export interface Value {
  readonly f: number;
  readonly pdf: number;
}

/** A drawn direction, its weight f |cos| / pdf, and its density; the weight 0 is a failure. */
export interface Sample {
  readonly direction: Vector;
  readonly weight: number;
  readonly pdf: number;
}

const NOTHING: Value = { f: 0, pdf: 0 };

/** The sample where there is no interface. */
function straight(wi: Vector): Sample {
  return { direction: negated(wi), weight: 1, pdf: 0 };
}

/** BRDF [1/sr] for two directions on the same side. */
export function reflection(wi: Vector, wo: Vector, alpha: number, eta: number): number {
  const lobe = reflectionLobe(wi, wo, alpha);
  return lobe > 0 ? lobe * dielectric(Math.abs(dot(wi, halfVector(wi, wo))), eta) : 0;
}

/** BTDF from wi (z > 0) to wo (z < 0), and the density of `sampleTransmission` there. */
export function transmission(wi: Vector, wo: Vector, alpha: number, eta: number): Value {
  if (!(wi.z > 0 && wo.z < 0) || eta === 1) {
    return NOTHING;
  }
  const [x, y, z] = [wi.x + eta * wo.x, wi.y + eta * wo.y, wi.z + eta * wo.z];
  const m = z < 0 ? normalised(-x, -y, -z) : normalised(x, y, z);
  const cosI = dot(wi, m);
  const cosO = dot(wo, m);
  if (!(cosI > 0 && cosO < 0)) {
    return NOTHING;
  }
  const pdf = visibleNormalDensity(wi, m, alpha) * jacobian(cosI, cosO, eta);
  const f = (pdf * (1 - dielectric(cosI, eta)) * masking(wo, alpha)) / -wo.z;
  return { f, pdf };
}

/** Of the refracted direction by the facet's normal (Walter et al. 2007, eq. 17). */
function jacobian(cosI: number, cosO: number, eta: number): number {
  const denominator = cosI + eta * cosO;
  return (eta * eta * -cosO) / (denominator * denominator);
}

/** Draw a reflected direction; its density is not computed. */
export function sampleReflection(
  wi: Vector,
  alpha: number,
  eta: number,
  u1: number,
  u2: number,
): Sample {
  const m = sampleVisibleNormal(wi, alpha, u1, u2);
  const direction = reflected(wi, m);
  const valid = direction.z > 0;
  const weight = valid ? dielectric(dot(wi, m), eta) * masking(direction, alpha) : 0;
  return { direction, weight, pdf: 0 };
}

/** Draw a refracted direction; its density is not computed. */
export function sampleTransmission(
  wi: Vector,
  alpha: number,
  eta: number,
  u1: number,
  u2: number,
): Sample {
  if (eta === 1) return straight(wi);
  const m = sampleVisibleNormal(wi, alpha, u1, u2);
  const cosI = dot(wi, m);
  const reflectance = dielectric(cosI, eta);
  const direction = refracted(wi, m, refractedCosine(cosI, eta), eta);
  const valid = direction.z < 0 && reflectance < 1;
  return { direction, weight: valid ? (1 - reflectance) * masking(direction, alpha) : 0, pdf: 0 };
}

/** Draw reflection or transmission in proportion to Fresnel. */
export function sample(
  wi: Vector,
  alpha: number,
  eta: number,
  u0: number,
  u1: number,
  u2: number,
): Sample {
  if (eta === 1) return straight(wi);
  const m = sampleVisibleNormal(wi, alpha, u1, u2);
  const cosI = dot(wi, m);
  const reflectance = dielectric(cosI, eta);
  const isReflected = u0 < reflectance;
  const direction = isReflected
    ? reflected(wi, m)
    : refracted(wi, m, refractedCosine(cosI, eta), eta);
  const valid = (isReflected ? direction.z > 0 : direction.z < 0) && cosI > 0;
  if (!valid) {
    return { direction, weight: 0, pdf: 0 };
  }
  const ratio = isReflected
    ? reflectance / (4 * cosI)
    : (1 - reflectance) * jacobian(cosI, dot(direction, m), eta);
  const pdf = visibleNormalDensity(wi, m, alpha) * ratio;
  return { direction, weight: masking(direction, alpha), pdf };
}

/** BSDF of both sides, and the density of `sample` at wo. */
export function scatter(wi: Vector, wo: Vector, alpha: number, eta: number): Value {
  const f = wo.z > 0 ? reflection(wi, wo, alpha, eta) : transmission(wi, wo, alpha, eta).f;
  // Sampling visible normals and Fresnel leaves one factor of f |cos| out: the masking of wo.
  return f > 0 ? { f, pdf: (f * Math.abs(wo.z)) / masking(wo, alpha) } : NOTHING;
}
