/**
 * The option `energyCompensation`: light that the topmost rough surface loses is given back.
 *
 * A surface scatters light once. Light that meets a second facet is lost. L(w) is the share that it
 * loses: a coat's over a white base, of which a part mirrors as the bottom does, or a metal's whose
 * facets reflect all light. The lobe C L(wi) L(wo) / (pi L_mean) gives it back (Kulla and Conty
 * 2017). C is the colour of coat and bottom, or of facets that reflect light more than once. See
 * `material.layer` and `core.facets` of Python.
 */

import { coatedColor, multipleAlbedo } from "../printed/formulas";
import type { Coat, Material } from "./api";
import { CHANNELS, rows } from "./channels";
import { clampedLog, nodePairs } from "./f_table";
import { type Loss, lossAt, mirrorLoss, surfaceLoss } from "./interface_loss";
import { passedBothWays, reflectance } from "./lobe";
import { gaussLegendre } from "./quadrature";
import { coatOfChannel } from "./surfaces";

/** What a surface loses in a channel, and the colour in which it is given back. */
export interface LostLight {
  readonly loss: Loss;
  readonly colour: number;
}

/** That of a coat over a material of an albedo (3) at the normal, and of f (3) away from mirrors. */
export function lostByCoat(coat: Coat, reflected: Float32Array, seen: Float32Array): LostLight[] {
  const mean = (values: Float32Array) => (values[0] + values[1] + values[2]) / 3;
  const diffuse = (Math.PI * mean(seen)) / Math.max(mean(reflected), 1e-6);
  const mirrored = Math.min(Math.max(1 - diffuse, 0), 1);
  return [0, 1, 2].map((channel) => {
    const { alpha, eta, albedo, sigmaT, g } = coatOfChannel(coat, channel);
    const name = `${alpha} ${eta} ${mirrored.toFixed(4)}`;
    const loss = known(name, () => surfaceLoss(alpha, eta, mirrored));
    const colour = coatedColor(eta, albedo, sigmaT, g, Math.min(reflected[channel], 1));
    return { loss, colour };
  });
}

/** Nodes of the mean of a Fresnel term over the cosine, as in Python. */
const { nodes: NODES, weights: WEIGHTS } = gaussLegendre(8);

/** That of a metal by the lobes of its channels. */
export function lostByMetal(lobes: readonly Float32Array[]): LostLight[] {
  return lobes.map((lobe) => {
    const loss = known(String(lobe[0]), () => mirrorLoss(lobe[0]));
    const mean = NODES.reduce((sum, node, k) => {
      const cosine = 0.5 * (node + 1);
      return sum + WEIGHTS[k] * cosine * reflectance(lobe, cosine);
    }, 0);
    return { loss, colour: multipleAlbedo(mean, 1 - loss.mean) };
  });
}

/** The latest losses, which stay the same while a coat's medium is changed. */
const losses = new Map<string, Loss>();

function known(name: string, compute: () => Loss): Loss {
  let found = losses.get(name);
  if (found === undefined) {
    if (losses.size > 30) losses.clear();
    found = compute();
    losses.set(name, found);
  }
  return found;
}

/** A material whose table has the light that its topmost surface loses, too. */
export function compensated(material: Material, lost: readonly LostLight[]): Material {
  const { table, latents } = material;
  const codes = rows(latents, latents.length / CHANNELS);
  const pairs = nodePairs();
  const { directions: w } = pairs;
  const logs = table.logs.map((log, at) => {
    const [node, channel] = [Math.floor(at / CHANNELS), at % CHANNELS];
    const z = 6 * node + 2;
    const { loss, colour } = lost[channel];
    const all = (lossAt(loss, w[z]) * lossAt(loss, w[z + 3])) / Math.max(Math.PI * loss.mean, 1e-5);
    const lobe = all / passedBothWays(codes[channel], pairs, node);
    return clampedLog(Math.log(Math.exp(log) + colour * lobe));
  });
  return { ...material, table: { logs, besideLobe: table.besideLobe } };
}
