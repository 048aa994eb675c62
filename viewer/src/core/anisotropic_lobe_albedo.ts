/**
 * Directional albedos of analytic lobes of two widths.
 *
 * The mean of F(c) G1(wo) over points of the spherical cap of visible normals (Dupuy and Benyoub
 * 2023), at the angles of the rule; see Python's `material.lobe_albedo`.
 */

import { type AlbedoRule, interpolatedAlbedos } from "./albedo_rule";
import { LOBE_ALBEDO } from "./formulas";
import { isDark, reflectance } from "./lobe";
import type { LobeAlbedos } from "./lobe_albedo";
import { gaussLegendre } from "./quadrature";

const { HEIGHTS, TURNS } = LOBE_ALBEDO;

const heights = gaussLegendre(HEIGHTS);
const turns = Array.from({ length: TURNS }, (_, k) => (2 * Math.PI * (k + 0.5)) / TURNS);
const cosines = turns.map(Math.cos);
const sines = turns.map(Math.sin);

export class AnisotropicLobeAlbedo implements LobeAlbedos {
  constructor(private readonly rule: AlbedoRule) {}

  add(lobe: ArrayLike<number>, at: number, albedos: Float64Array): void {
    if (isDark(lobe, at)) return;
    const { rule } = this;
    const atAngles = Float64Array.from(rule.angles, (_, k) => {
      const first = 3 * rule.bounds[k];
      return albedoAt(lobe, at, rule.wi[first], rule.wi[first + 1], rule.wi[first + 2]);
    });
    interpolatedAlbedos(rule, atAngles).forEach((albedo, d) => {
      albedos[d] += albedo;
    });
  }

  /** There are no tables to make. */
  prepare(): void {}
}

/** The albedo of a lobe for one direction. */
function albedoAt(lobe: ArrayLike<number>, at: number, x: number, y: number, z: number): number {
  const [u, v] = [lobe[at], lobe[at + 6]];
  const length = Math.hypot(u * x, v * y, z);
  const [ahead, aside, up] = [(u * x) / length, (v * y) / length, z / length];
  let sum = 0;
  for (let i = 0; i < HEIGHTS; i++) {
    const level = 0.5 * (heights.nodes[i] + 1) * (1 + up) - up;
    const across = Math.sqrt(Math.max(1 - level * level, 0));
    const fz = level + up;
    const share = (0.5 * heights.weights[i]) / TURNS;
    for (let k = 0; k < TURNS; k++) {
      const fx = u * (across * cosines[k] + ahead);
      const fy = v * (across * sines[k] + aside);
      const norm2 = fx * fx + fy * fy + fz * fz;
      const along = x * fx + y * fy + z * fz;
      const twice = (2 * along) / norm2;
      const out = twice * fz - z;
      if (out > 0) {
        const [ox, oy, raised] = [u * (twice * fx - x), v * (twice * fy - y), Math.max(out, 1e-6)];
        const slope2 = (ox * ox + oy * oy) / (raised * raised);
        const masking = 2 / (1 + Math.sqrt(1 + slope2));
        sum += share * masking * reflectance(lobe, at, Math.min(along / Math.sqrt(norm2), 1));
      }
    }
  }
  return sum;
}
