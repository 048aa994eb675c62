/**
 * The option `energyCompensation`: light that the topmost coat's rough surface loses is given back.
 *
 * A surface scatters light once. Light that meets a second facet is lost. L(w) is the share that the
 * topmost surface loses over a white base, of which a part mirrors as the bottom does. The lobe
 * C L(wi) L(wo) / (pi L_mean) gives it back (Kulla and Conty 2017). C is the colour of coat and
 * bottom. See `material.layer` of Python.
 */

import type { Coat, Material } from "./api";
import { CHANNELS } from "./channels";
import type { Evaluation } from "./evaluation";
import { clampedLog, nodePairs } from "./f_table";
import { APPEARANCE, coatedColor } from "./formulas";
import { type Loss, surfaceLoss } from "./interface_loss";
import { coatOfChannel } from "./surfaces";

/** Nodes of the cosine, whose roots have equal distances. */
const COSINES = Float32Array.from({ length: 33 }, (_, k) => Math.max(k / 32, 0.003) ** 2);

const { WI, WO } = APPEARANCE;

interface Lobe {
  /** C / (pi L_mean) of the channels. */
  readonly factors: readonly number[];
  /** (N, 3) L at N cosines. */
  readonly lost: Float32Array;
}

/** The lobe of a coat over a material. */
function lobeOver(coat: Coat, below: Material, core: Pick<Evaluation, "albedo" | "f">): Lobe {
  const reflected = core.albedo(below, Float32Array.of(1));
  const seen = core.f(below, Float32Array.from(WI), Float32Array.from(WO));
  const mean = (values: Float32Array) => (values[0] + values[1] + values[2]) / 3;
  const diffuse = (Math.PI * mean(seen)) / Math.max(mean(reflected), 1e-6);
  const mirrored = Math.min(Math.max(1 - diffuse, 0), 1);
  const lost = new Float32Array(CHANNELS * COSINES.length);
  const factors = [0, 1, 2].map((channel) => {
    const { alpha, eta, albedo, sigmaT, g } = coatOfChannel(coat, channel);
    const loss = lossOf(alpha, eta, mirrored);
    loss.at.forEach((share, k) => {
      lost[CHANNELS * k + channel] = share;
    });
    const colour = coatedColor(eta, albedo, sigmaT, g, Math.min(reflected[channel], 1));
    return colour / Math.max(Math.PI * loss.mean, 1e-5);
  });
  return { factors, lost };
}

/** The latest losses, which stay the same while a coat's medium is changed. */
const losses = new Map<string, Loss>();

function lossOf(alpha: number, eta: number, mirrored: number): Loss {
  const name = `${alpha} ${eta} ${mirrored.toFixed(4)}`;
  let found = losses.get(name);
  if (found === undefined) {
    if (losses.size > 30) losses.clear();
    found = surfaceLoss(alpha, eta, mirrored, COSINES);
    losses.set(name, found);
  }
  return found;
}

/** A coated material whose table has the lobe of its topmost coat, too. */
export function compensated(
  material: Material,
  coat: Coat,
  below: Material,
  core: Pick<Evaluation, "albedo" | "f">,
): Material {
  const { factors, lost } = lobeOver(coat, below, core);
  const { table } = material;
  const { directions: w } = nodePairs();
  const logs = table.logs.map((log, at) => {
    const [z, channel] = [6 * Math.floor(at / CHANNELS) + 2, at % CHANNELS];
    const lobe = factors[channel] * lostAt(lost, channel, w[z]) * lostAt(lost, channel, w[z + 3]);
    return clampedLog(Math.log(Math.exp(log) + lobe));
  });
  return { ...material, table: { logs, besideLobe: table.besideLobe } };
}

/** L at a cosine, linear in its root. */
function lostAt(lost: Float32Array, channel: number, cosine: number): number {
  const last = COSINES.length - 1;
  const place = Math.sqrt(Math.min(Math.max(cosine, 0), 1)) * last;
  const first = Math.min(Math.floor(place), last - 1);
  const low = lost[CHANNELS * first + channel]!;
  return low + (place - first) * (lost[CHANNELS * (first + 1) + channel]! - low);
}
