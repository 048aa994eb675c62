/** BRDFs of described bottoms, for one channel of the random walk. */

import { fresnel, schlick } from "../formulas";
import { ofChannel, type Surface } from "../surfaces";
import type { Sample, Value } from "./interface";
import {
  dielectric,
  masking,
  reflectionLobe,
  sampleCosine,
  sampleVisibleNormal,
  visibleNormalDensity,
} from "./microfacet";
import { dot, halfVector, reflected, type Vector } from "./vector";

/** The BRDF under the lowest medium. */
export interface WalkedBottom {
  /** BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon. */
  value(wi: Vector, wo: Vector): Value;
  /** Draw wo by two uniform numbers. */
  sample(wi: Vector, u1: number, u2: number): Sample;
}

/** The bottom of one channel. */
export function bottomOf(surface: Surface, channel: number): WalkedBottom {
  if (surface.kind === "diffuse") {
    return lambertian(ofChannel(surface.reflectance, channel));
  }
  const alpha = ofChannel(surface.alpha, channel);
  if (surface.kind === "dielectric") {
    const eta = ofChannel(surface.eta, channel);
    return microfacets(alpha, (cosine) => dielectric(cosine, eta));
  }
  if ("r0" in surface) {
    const r0 = ofChannel(surface.r0, channel);
    return microfacets(alpha, (cosine) => schlick(r0, 1, cosine));
  }
  const [eta, k] = [ofChannel(surface.eta, channel), ofChannel(surface.k, channel)];
  return microfacets(alpha, (cosine) => fresnel(cosine, eta, k));
}

function lambertian(albedo: number): WalkedBottom {
  return {
    value: (wi, wo) => {
      const valid = wi.z > 0 && wo.z > 0;
      return { f: valid ? albedo / Math.PI : 0, pdf: valid ? wo.z / Math.PI : 0 };
    },
    sample: (_, u1, u2) => {
      const direction = sampleCosine(u1, u2);
      return { direction, weight: albedo, pdf: direction.z / Math.PI };
    },
  };
}

/** A GGX reflector of a Fresnel term. */
function microfacets(alpha: number, term: (cosine: number) => number): WalkedBottom {
  return {
    value: (wi, wo) => {
      const lobe = reflectionLobe(wi, wo, alpha);
      if (!(lobe > 0)) {
        return { f: 0, pdf: 0 };
      }
      const f = lobe * term(Math.min(Math.abs(dot(wi, halfVector(wi, wo))), 1));
      return { f, pdf: (lobe * wo.z) / masking(wo, alpha) };
    },
    sample: (wi, u1, u2) => {
      const m = sampleVisibleNormal(wi, alpha, u1, u2);
      const cosine = dot(wi, m);
      const direction = reflected(wi, m);
      if (!(direction.z > 0)) {
        return { direction, weight: 0, pdf: 0 };
      }
      const weight = term(Math.min(Math.abs(cosine), 1)) * masking(direction, alpha);
      return { direction, weight, pdf: visibleNormalDensity(wi, m, alpha) / (4 * cosine) };
    },
  };
}
