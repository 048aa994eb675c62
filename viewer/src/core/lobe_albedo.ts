/**
 * Directional albedos of analytic lobes, for all widths and Fresnel terms.
 *
 * The albedo is the mean of F(c) G1(wo) over visible normals, where c is the cosine to the facet.
 * For a width and an angle, a Gauss rule of few nodes represents the distribution of c with these
 * weights. Rules are made for some widths and interpolated; see Python's `material.lobe_albedo`.
 */

import { CHECKS, LOBE_ALBEDO } from "./formulas";
import { isDark, reflectance } from "./lobe";
import { gaussLegendre, type Rule, ruleOfMatrix } from "./quadrature";

const { NODES, EDGE_NODES, WIDTHS, FINE } = LOBE_ALBEDO;
const LEAST_ROOT = Math.sqrt(CHECKS.MIN_ALPHA);

/** Cosines to the facet and weights of an angle's nodes, one angle after the other. */
interface FacetRules {
  readonly cosines: Float32Array;
  readonly weights: Float32Array;
}

/** Albedos of lobes at the directions of a rule. */
export interface LobeAlbedos {
  /** Add the albedos of the lobe whose numbers begin at a place to `albedos`. */
  add(lobe: ArrayLike<number>, at: number, albedos: Float64Array): void;
  /** Make what `add` needs near width `index` below `WIDTHS`. */
  prepare(index: number): void;
}

/** Albedos of lobes of one width at given cosines of directions. */
export class LobeAlbedo implements LobeAlbedos {
  private readonly made = new Map<number, FacetRules>();

  constructor(private readonly cosines: Float64Array) {}

  /** Add the albedos of the lobe whose six numbers begin at a place to `albedos`. */
  add(lobe: ArrayLike<number>, at: number, albedos: Float64Array): void {
    if (isDark(lobe, at)) return;
    const nodes = lobe[at + 3] > 0 && lobe[at + 4] < 1 ? EDGE_NODES : NODES;
    const place = ((Math.sqrt(lobe[at]) - LEAST_ROOT) / (1 - LEAST_ROOT)) * (WIDTHS - 1);
    const clamped = Math.min(Math.max(place, 0), WIDTHS - 1);
    const index = Math.min(Math.floor(clamped), WIDTHS - 2);
    const share = clamped - index;
    const below = this.rules(index, nodes);
    const above = this.rules(index + 1, nodes);
    for (let d = 0; d < this.cosines.length; d++) {
      let sum = 0;
      for (let k = d * nodes; k < (d + 1) * nodes; k++) {
        const cosine = (1 - share) * below.cosines[k] + share * above.cosines[k];
        const weight = (1 - share) * below.weights[k] + share * above.weights[k];
        sum += weight * reflectance(lobe, at, cosine);
      }
      albedos[d] += sum;
    }
  }

  /** Make the rules of width `index` below `WIDTHS`, which takes milliseconds, unless they exist. */
  prepare(index: number): void {
    this.rules(index, NODES);
  }

  private rules(index: number, nodes: number): FacetRules {
    const key = index * (EDGE_NODES + 1) + nodes;
    let found = this.made.get(key);
    if (!found) {
      const share = index / (WIDTHS - 1);
      found = facetRules((LEAST_ROOT * (1 - share) + share) ** 2, this.cosines, nodes);
      this.made.set(key, found);
    }
    return found;
  }
}

function facetRules(alpha: number, cosines: Float64Array, nodes: number): FacetRules {
  const facets = new Facets();
  const found = new Float32Array(cosines.length * nodes);
  const shares = new Float32Array(cosines.length * nodes);
  cosines.forEach((cosine, d) => {
    facets.set(alpha, Math.min(cosine, 1));
    const rule = facets.gaussRule(nodes);
    found.set(rule.nodes, d * nodes);
    shares.set(rule.weights, d * nodes);
  });
  return { cosines: found, weights: shares };
}

const legendre = gaussLegendre(FINE);
const azimuths = legendre.nodes.map((node) => 0.5 * Math.PI * (node + 1));
const cosPhi = azimuths.map(Math.cos);
const sinPhi = azimuths.map(Math.sin);

/**
 * Cosines to facets, and weights that integrate F(c) f cos over the hemisphere.
 *
 * The facets lie evenly on the spherical cap of visible normals (Dupuy and Benyoub 2023).
 */
class Facets {
  private readonly cosines = new Float64Array(FINE * FINE);
  private readonly weights = new Float64Array(FINE * FINE);
  private current = new Float64Array(FINE * FINE);
  private previous = new Float64Array(FINE * FINE);

  /** Set a width, and the cosine of the direction. */
  set(alpha: number, cosine: number): void {
    const sine = Math.sqrt(1 - cosine * cosine);
    const length = Math.hypot(alpha * sine, cosine);
    const x = (alpha * sine) / length;
    const z = cosine / length;
    for (let k = 0; k < FINE; k++) {
      const height = 0.5 * (legendre.nodes[k] + 1) * (1 + z) - z;
      const across = Math.sqrt(Math.max(1 - height * height, 0));
      const fz = height + z;
      for (let i = 0; i < FINE; i++) {
        const fx = alpha * (across * cosPhi[i] + x);
        const fy = alpha * across * sinPhi[i];
        const norm = Math.sqrt(fx * fx + fy * fy + fz * fz);
        const toFacet = (sine * fx + cosine * fz) / norm;
        const out = (2 * toFacet * fz) / norm - cosine;
        const raised = Math.max(out, 1e-9);
        const masking = 2 / (1 + Math.sqrt(1 + alpha * alpha * (1 / (raised * raised) - 1)));
        const weight = 0.25 * legendre.weights[i] * legendre.weights[k] * masking;
        const at = k * FINE + i;
        this.cosines[at] = toFacet;
        this.weights[at] = out > 0 ? weight : 0;
      }
    }
  }

  /** The Gauss rule of sums over the facets, by the method of Lanczos. */
  gaussRule(nodes: number): Rule {
    let squared = 0;
    let weighted = 0;
    for (let i = 0; i < this.weights.length; i++) {
      this.current[i] = Math.sqrt(this.weights[i]);
      this.previous[i] = 0;
      squared += this.weights[i];
      weighted += this.weights[i] * this.cosines[i];
    }
    const total = squared;
    const diagonal = new Float64Array(nodes);
    const beside = new Float64Array(nodes);
    let factor = 1 / Math.sqrt(squared);
    let below = 0;
    for (let k = 0; k < nodes; k++) {
      const mean = weighted / squared;
      diagonal[k] = mean;
      [squared, weighted] = this.advance(mean, factor, below);
      below = Math.sqrt(squared);
      beside[k] = below;
      factor = 1 / Math.max(below, 1e-30);
    }
    const rule = ruleOfMatrix(diagonal, beside, 0);
    return {
      nodes: rule.nodes.map((node) => Math.min(Math.max(node, 0), 1)),
      weights: rule.weights.map((weight) => weight * total),
    };
  }

  /**
   * Make the next vector of the basis; returns its squared length, and the same weighted by cosines.
   *
   * @param factor by which the current vector gets the length one; the previous one has it.
   */
  private advance(mean: number, factor: number, below: number): [number, number] {
    const { cosines, current, previous } = this;
    let squared = 0;
    let weighted = 0;
    for (let i = 0; i < cosines.length; i++) {
      const x = cosines[i];
      const own = current[i] * factor;
      const next = (x - mean) * own - below * previous[i];
      current[i] = own;
      previous[i] = next;
      squared += next * next;
      weighted += x * next * next;
    }
    this.current = previous;
    this.previous = current;
    return [squared, weighted];
  }
}
