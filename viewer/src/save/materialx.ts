/** A material as an `open_pbr_surface` of a MaterialX document, as far as OpenPBR can express it. */

import type { Channels } from "../core/api";
import { colourOver, hiddenBy, lookOf } from "../material/appearance";
import { each, mapped, quotient, type Rgb, rgb } from "../material/channels";
import {
  type BottomInAir,
  bottomUnder,
  type CoatCard,
  type CoatInAir,
  hasSurface,
  isAnisotropic,
  type MaterialCards,
  reflectanceOf,
  seenOf,
  type Widths,
} from "../material/material";
import { CHECKS, fresnel, schlick } from "../printed/formulas";
import { Refusal } from "../refusal";

/** Cosine at which a metal has its tint, about 82 degrees. */
const EDGE_COSINE = 1 / 7;

/** Values of the inputs by their names, and what is lost. */
interface Description {
  inputs: Record<string, number | Rgb>;
  lost: string[];
}

/**
 * The document, and a sentence on what it leaves out; "" if nothing.
 *
 * @throws Refusal if the bottom is a loaded one.
 */
export function materialxText(material: MaterialCards): { text: string; lost: string } {
  const { inputs, lost } = describe(material);
  const lines = Object.entries(inputs).map(([name, value]) => {
    const [type, text] =
      typeof value === "number" ? ["float", value] : ["color3", value.join(", ")];
    return `    <input name="${name}" type="${type}" value="${text}" />`;
  });
  const text = [
    '<?xml version="1.0"?>',
    '<materialx version="1.39" colorspace="lin_rec709">',
    '  <open_pbr_surface name="surface" type="surfaceshader">',
    ...lines,
    "  </open_pbr_surface>",
    '  <surfacematerial name="material" type="material">',
    '    <input name="surfaceshader" type="surfaceshader" nodename="surface" />',
    "  </surfacematerial>",
    "</materialx>",
    "",
  ].join("\n");
  const sentence = `The document leaves out what OpenPBR does not have: ${lost.join(", ")}.`;
  return { text, lost: lost.length > 0 ? sentence : "" };
}

function describe(material: MaterialCards): Description {
  const { bottom, coats } = seenOf(material);
  const lost: string[] = [];
  const nameOf = ({ id }: CoatCard) =>
    `coat ${material.coats.length - material.coats.findIndex((coat) => coat.id === id)}`;
  const [top, ...inner] = coats;
  // What lies below an opaque coat is not seen: the coat's body is the base.
  const isHidden = coats.some((coat) => Math.min(...hiddenBy(coat, depthOf(coat))) >= 0.5);
  const index = quotient(coats.at(-1)?.ior ?? CHECKS.AIR, CHECKS.AIR);
  const under = bottomUnder(bottom, index);
  const surfaces = inner.filter((coat) => hasSurface(material, coat));
  let inputs: Description["inputs"];
  if (under.kind === "diffuse" || (isHidden && under.kind !== "codes")) {
    // The dye of the topmost coat is the colour of OpenPBR's; all other colours are the base's.
    const color = coats.reduceRight<Rgb>(
      (below, coat) =>
        colourOver(coat === top ? { ...lookOf(coat), color: 1, g: 0 } : coat, depthOf(coat), below),
      reflectanceOf(under),
    );
    const gloss = surfaces.shift();
    inputs = gloss
      ? glossOf(gloss, color, top!.ior, lost)
      : baseOf({ kind: "diffuse", reflectance: color }, lost);
  } else {
    inputs = baseOf(under, lost);
    const dye = inner.reduce<Rgb>(
      (above, coat) => colourOver({ ...lookOf(coat), body: 0, g: 0 }, depthOf(coat), above),
      [1, 1, 1],
    );
    const base = inputs.base_color as Rgb | undefined;
    if (base) inputs.base_color = each((k) => base[k] * dye[k]);
    else if (dye.some((share) => share !== 1)) lost.push("the colour of the lower coats");
    for (const coat of coats)
      if (mean(lookOf(coat).body) > 0) lost.push(`the body of ${nameOf(coat)} and its colour`);
  }
  lost.push(...surfaces.map((coat) => `the surface of ${nameOf(coat)}`));
  if (top !== undefined)
    Object.assign(inputs, {
      coat_weight: 1,
      coat_color: rgb(mapped(lookOf(top).color, (share) => share ** depthOf(top))),
      ...surfaceOf("coat", top, lost),
      coat_ior: one(top.ior, "the coat's index of each channel", lost),
    });
  if (isAnisotropic({ bottom, coats }) && (material.rotation ?? 0) !== 0)
    lost.push("the tangent's angle");
  return { inputs, lost };
}

function depthOf({ thickness = 1 }: CoatInAir): number {
  return thickness;
}

/** The inputs of a bottom without gloss of its own. */
function baseOf(bottom: BottomInAir, lost: string[]): Description["inputs"] {
  switch (bottom.kind) {
    case "diffuse":
      return { base_color: rgb(bottom.reflectance), specular_weight: 0 };
    case "dielectric": {
      const { specular_roughness } = surfaceOf("specular", bottom, lost);
      const specular_ior = one(bottom.ior, "the bottom's index of each channel", lost);
      return { base_weight: 0, specular_roughness: specular_roughness!, specular_ior };
    }
    case "codes":
      throw new Refusal(
        "A loaded material cannot be written as MaterialX; save the material, or its code.",
      );
  }
  return { ...metalOf(bottom), base_metalness: 1, ...surfaceOf("specular", bottom, lost) };
}

/** Reflectance at normal incidence, and the share of Schlick's term that is left at the edge. */
function metalOf(bottom: BottomInAir & { kind: "conductor" }): Description["inputs"] {
  if ("r0" in bottom) return { base_color: rgb(bottom.r0) };
  const [eta, k] = [rgb(bottom.eta), rgb(bottom.k)];
  const f0 = each((i) => fresnel(1, eta[i], k[i]));
  const tint = each((i) =>
    Math.min(fresnel(EDGE_COSINE, eta[i], k[i]) / schlick(f0[i], 1, EDGE_COSINE), 1),
  );
  return { base_color: f0, specular_color: tint };
}

/** The interface of the base: a clear coat over a Lambertian bottom. */
function glossOf(
  coat: CoatInAir,
  reflectance: Channels,
  above: Channels,
  lost: string[],
): Description["inputs"] {
  const surface = surfaceOf("specular", coat, lost);
  const ior = one(coat.ior, "the bottom's index of each channel", lost);
  const inside = internalReflectance(ior / mean(above));
  return {
    base_color: rgb(mapped(reflectance, (rho) => ((1 - inside) * rho) / (1 - rho * inside))),
    specular_weight: 1,
    ...surface,
    specular_ior: ior,
  };
}

/**
 * The share of diffuse light that a smooth interface reflects down again; see Python's
 * `openpbr_surface.formulas`. The mean reflectance is a fit (Kulla and Conty 2017).
 */
function internalReflectance(eta: number): number {
  if (eta <= 1) return 0;
  return 1 - (1 - (eta - 1) / (4.08567 + 1.00071 * eta)) / (eta * eta);
}

/** OpenPBR's roughness r and anisotropy a: widths r^2 s and r^2 s (1 - a), s^2 = 2 / (1 + (1 - a)^2). */
function surfaceOf(
  part: "coat" | "specular",
  { alpha, alphaV }: Widths,
  lost: string[],
): Record<string, number> {
  const what = `the ${part === "coat" ? part : "bottom"}'s roughness of each channel`;
  const [along, across] = [one(alpha, what, lost), mean(alphaV ?? alpha)];
  if (across > along) lost.push("a width across the tangent above that along it");
  const ratio = Math.min(across / along, 1);
  const width = across > along ? Math.sqrt(along * across) : along;
  const stretch = Math.sqrt(2 / (1 + ratio * ratio));
  return {
    [`${part}_roughness`]: digits(Math.sqrt(width / stretch)),
    [`${part}_roughness_anisotropy`]: digits(1 - ratio),
  };
}

/** The mean of the channels; what: their difference, which is lost. */
function one(value: Channels, what: string, lost: string[]): number {
  if (new Set(rgb(value)).size > 1 && !lost.includes(what)) lost.push(what);
  return mean(value);
}

function mean(value: Channels): number {
  const [red, green, blue] = rgb(value);
  return red === green && green === blue ? red : (red + green + blue) / 3;
}

function digits(value: number): number {
  return Number(value.toFixed(6));
}
