/**
 * The option `energyCompensation`: light that the topmost coat's rough surface loses is given back.
 *
 * A surface scatters light once. Light that meets a second facet is lost. L(w) is the share that a
 * clear coat with this surface loses over a white bottom. The lobe C L(wi) L(wo) / (pi L_mean) gives
 * it back (Kulla and Conty 2017). C is the colour of coat and bottom. See `walk.compensation` of
 * Python. A coat over a mirror loses less. L is therefore the mean of the losses over white and over
 * a mirror, weighted by the share that the bottom mirrors. The networks compute the losses, so that
 * clear coats over white reflect all light.
 */

import type { Coat, Compensation, Core, Material } from "./api";
import { CHANNELS } from "./channels";
import { clampedLog, nodePairs } from "./f_table";
import { APPEARANCE, coatedColor } from "./formulas";
import { ofChannel } from "./surfaces";

/** Nodes of the cosine, whose roots have equal distances. */
const COSINES = Float32Array.from({ length: 13 }, (_, k) => Math.max(k / 12, 0.02) ** 2);

const { WI, WO } = APPEARANCE;
const WHITE = { kind: "diffuse", reflectance: 1 } as const;
const MIRROR = { kind: "conductor", alpha: 0.02, r0: 1 } as const;

/** What the lobe is computed by. */
type Networks = Pick<Core, "layer" | "albedo" | "f">;

/** Makes lobes of coats; the latest surface's loss is kept while its medium is changed. */
export class Compensations {
  private latest: { readonly name: string; readonly lost: readonly Float32Array[] } | undefined;

  constructor(private readonly networks: Networks) {}

  /** The lobe of a coat over a material. */
  of(coat: Coat, below: Material): Compensation {
    const [reflected, white] = [below, this.networks.layer({ bottom: WHITE, coats: [] })].map(
      (material) => this.networks.albedo(material, Float32Array.of(1)),
    ) as [Float32Array, Float32Array];
    const f = this.networks.f(below, Float32Array.from(WI), Float32Array.from(WO));
    const diffuse = (Math.PI * (f[0] + f[1] + f[2])) / (reflected[0] + reflected[1] + reflected[2]);
    const mirrored = Math.min(Math.max(1 - diffuse, 0), 1);
    const [over, overMirror] = this.lostBy(coat);
    const lost = over.map((share, at) => share + mirrored * (overMirror[at] - share));
    const factors = [0, 1, 2].map((k) => {
      const [eta, albedo, depth, g] = [coat.eta, coat.albedo, coat.sigmaT, coat.g].map((value) =>
        ofChannel(value, k),
      ) as [number, number, number, number];
      const share = Math.min(reflected[k] / white[k], 1);
      const colour = coatedColor(eta, albedo, depth, g, share);
      return colour / Math.max(Math.PI * hemisphereMean(lost, k), 1e-5);
    });
    return { factors, lost };
  }

  /** What the surface of a coat loses over white, and over a mirror. */
  private lostBy({ alpha, alphaV = alpha, eta }: Coat): readonly Float32Array[] {
    const name = JSON.stringify([alpha, alphaV, eta]);
    if (this.latest?.name !== name) {
      const mean = (k: number) =>
        Math.hypot(ofChannel(alpha, k), ofChannel(alphaV, k)) / Math.SQRT2;
      const clear = {
        alpha: [mean(0), mean(1), mean(2)],
        eta,
        albedo: 0,
        sigmaT: 0,
        g: 0,
      } as const;
      const lost = [WHITE, MIRROR].map((bottom) =>
        this.networks
          .albedo(this.networks.layer({ bottom, coats: [clear] }), COSINES)
          .map((share, at) => (ofChannel(eta, at % CHANNELS) === 1 ? 0 : Math.max(1 - share, 0))),
      );
      this.latest = { name, lost };
    }
    return this.latest.lost;
  }
}

/** The material whose table has the lobe too; one of two widths keeps it beside. */
export function withLobe(material: Material, lobe: Compensation): Material {
  const { table } = material;
  if (table.stretches) return { ...material, compensation: lobe };
  const { wi, wo } = nodePairs();
  const logs = table.logs.map((log, at) => {
    const z = 3 * Math.floor(at / CHANNELS) + 2;
    return clampedLog(Math.log(Math.exp(log) + lobeOf(lobe, at % CHANNELS, wi[z], wo[z])));
  });
  return { ...material, table: { logs, besideLobe: table.besideLobe } };
}

/** The lobe [1/sr] of a channel at two cosines. */
export function lobeOf(
  { factors, lost }: Compensation,
  channel: number,
  cosI: number,
  cosO: number,
): number {
  return factors[channel]! * lostAt(lost, channel, cosI) * lostAt(lost, channel, cosO);
}

/** L at a cosine, linear in its root. */
function lostAt(lost: Float32Array, channel: number, cosine: number): number {
  const last = COSINES.length - 1;
  const place = Math.sqrt(Math.min(Math.max(cosine, 0), 1)) * last;
  const first = Math.min(Math.floor(place), last - 1);
  const low = lost[CHANNELS * first + channel]!;
  return low + (place - first) * (lost[CHANNELS * (first + 1) + channel]! - low);
}

/** The mean of L over the hemisphere, weighted by the cosine. */
function hemisphereMean(lost: Float32Array, channel: number): number {
  const steps = 96;
  let sum = 0;
  for (let k = 0; k < steps; k++) {
    const root = (k + 0.5) / steps;
    sum += (4 * root ** 3 * lostAt(lost, channel, root * root)) / steps;
  }
  return sum;
}
