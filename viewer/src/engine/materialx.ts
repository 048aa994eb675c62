/** MaterialX documents: one `open_pbr_surface` or `standard_surface` of constant inputs. */

import type { Channels } from "../core/api";
import { CHECKS } from "../core/formulas";
import { joined, mapped, type Rgb, rgb } from "../material/channels";
import type { BottomInAir, CoatCard, MaterialCards } from "../material/material";
import { Refusal } from "../refusal";
import { internalReflectance } from "../save/materialx";

const CONVERT = "urushi convert writes it as a Mitsuba scene.";

const OPENPBR = "open_pbr_surface";

/** Parameters of OpenPBR and their defaults. */
const DEFAULTS: Record<string, Channels> = {
  base_weight: 1,
  base_color: 0.8,
  base_metalness: 0,
  specular_weight: 1,
  specular_color: 1,
  specular_roughness: 0.3,
  specular_ior: 1.5,
  specular_roughness_anisotropy: 0,
  coat_weight: 0,
  coat_color: 1,
  coat_roughness: 0,
  coat_roughness_anisotropy: 0,
  coat_ior: 1.6,
};

/** Inputs of standard_surface that are parameters, where names or defaults differ. */
const STANDARD: Record<string, [name: string, fallback: Channels]> = {
  base_weight: ["base", 1],
  base_metalness: ["metalness", 0],
  specular_weight: ["specular", 1],
  specular_roughness: ["specular_roughness", 0.2],
  specular_ior: ["specular_IOR", 1.5],
  specular_roughness_anisotropy: ["specular_anisotropy", 0],
  coat_weight: ["coat", 0],
  coat_roughness: ["coat_roughness", 0.1],
  coat_roughness_anisotropy: ["coat_anisotropy", 0],
  coat_ior: ["coat_IOR", 1.5],
};

/** Inputs that the page does not show, and the values at which they change nothing. */
const UNSEEN: Record<string, number> = {
  ...{ base_diffuse_roughness: 0, transmission_weight: 0, subsurface_weight: 0, fuzz_weight: 0 },
  ...{ thin_film_weight: 0, emission_luminance: 0, geometry_opacity: 1, coat_darkening: 1 },
  ...{ diffuse_roughness: 0, transmission: 0, subsurface: 0, sheen: 0, emission: 0, opacity: 1 },
  ...{ thin_film_thickness: 0, coat_affect_color: 0, coat_affect_roughness: 0 },
};

/**
 * The bottom and the coats of a document, and the inputs that are not shown.
 *
 * @throws Refusal if it is no such document, or has images or graphs.
 */
export function readMaterialx(
  bytes: Uint8Array,
): Pick<MaterialCards, "bottom" | "coats"> & { lost: string[] } {
  const text = new TextDecoder().decode(bytes);
  if (!text.trimStart().startsWith("<")) throw new Refusal("It is no MaterialX document.");
  const document = new DOMParser().parseFromString(text, "application/xml");
  if (document.querySelector("parsererror") !== null || !document.querySelector("materialx"))
    throw new Refusal("It is no MaterialX document.");
  const shaders = [...document.querySelectorAll(`${OPENPBR}, standard_surface`)];
  if (shaders.length !== 1)
    throw new Refusal(
      `It has ${shaders.length} shaders of kind open_pbr_surface or standard_surface, and the page opens one; ${CONVERT}`,
    );
  const shader = shaders[0]!;
  const given = new Map<string, Channels>();
  for (const input of shader.querySelectorAll("input")) {
    const name = input.getAttribute("name") ?? "";
    const connected = ["nodename", "nodegraph", "interfacename", "output"];
    if (connected.some((link) => input.hasAttribute(link)))
      throw new Refusal(`Its input ${name} is an image or a graph; ${CONVERT}`);
    if (["float", "color3", "boolean"].includes(input.getAttribute("type") ?? ""))
      given.set(name, constantOf(input, name));
  }
  const isStandard = shader.localName !== OPENPBR;
  const of = (name: string): Channels => {
    const [own, fallback] = (isStandard && STANDARD[name]) || [name, DEFAULTS[name]!];
    return given.get(own) ?? fallback;
  };
  // As in the graphs of both shaders: an anisotropic surface's larger width over roughness squared.
  const stretch = (ratio: number) =>
    isStandard ? 1 / Math.sqrt(ratio) : Math.sqrt(2 / (1 + ratio * ratio));
  const lost = Object.entries(UNSEEN).flatMap(([name, value]) =>
    rgb(given.get(name) ?? value).every((x) => x === value) ? [] : [name],
  );
  if (isStandard && mean(of("coat_weight")) > 0) lost.push("the coat that does not darken");
  const isMetal = mean(of("base_metalness")) >= 0.5;
  const parameters = { of, stretch, metalWeight: isStandard ? 1 : mean(of("specular_weight")) };
  if (!isStandard || !isMetal)
    if (rgb(of("specular_color")).some((x) => x !== 1)) lost.push("specular_color");
  return { ...cardsOf(parameters, lost), lost };
}

/** A shader by OpenPBR's parameters; metalWeight: factor of a metal's reflectance. */
interface Parameters {
  of: (name: string) => Channels;
  stretch: (ratio: number) => number;
  metalWeight: number;
}

/** Cards of the parameters of OpenPBR. */
function cardsOf(parameters: Parameters, lost: string[]): Pick<MaterialCards, "bottom" | "coats"> {
  const { of } = parameters;
  const share = (name: string) => {
    const value = mean(of(name));
    if (value !== 0 && value !== 1) lost.push(`${name} between 0 and 1`);
    return value >= 0.5;
  };
  const isCoated = share("coat_weight");
  const coats: CoatCard[] = [];
  if (isCoated) coats.push(coatOf(parameters, "coat", mean(of("coat_ior")), of("coat_color")));
  const [weight, base] = [mean(of("base_weight")), rgb(of("base_color"))];
  const color = joined(base.map((x) => x * weight) as unknown as Rgb);
  const ofSpecular = mean(of("specular_weight"));
  let bottom: BottomInAir;
  if (share("base_metalness")) {
    const r0 = mapped(color, (x) => Math.min(x * parameters.metalWeight, 1));
    bottom = { kind: "conductor", ...widths(parameters, "specular"), r0 };
  } else if (ofSpecular === 0) {
    bottom = { kind: "diffuse", reflectance: color };
  } else {
    const above = isCoated ? mean(of("coat_ior")) : CHECKS.AIR;
    const ratio = modulated(mean(of("specular_ior")) / above, ofSpecular);
    const inside = internalReflectance(ratio);
    const reflectance = mapped(color, (x) => x / (1 - inside + x * inside));
    coats.push(coatOf(parameters, "specular", ratio * above, 1));
    bottom = { kind: "diffuse", reflectance };
  }
  return { bottom, coats: coats.map((coat, place) => ({ ...coat, id: place + 1 })) };
}

/** The relative index of a reflectance that is `weight` times that of another. */
function modulated(ratio: number, weight: number): number {
  const amplitude = ((ratio - 1) / (ratio + 1)) * Math.sqrt(weight);
  const scaled = Math.min(Math.max(amplitude, -0.99), 0.99);
  return (1 + scaled) / (1 - scaled);
}

function coatOf(parameters: Parameters, prefix: string, ior: number, color: Channels): CoatCard {
  const medium = { color, body: 0, bodyColor: 0.8, g: 0 };
  return { id: 0, on: true, ...widths(parameters, prefix), ior, ...medium };
}

/** The GGX widths of a roughness and an anisotropy, within the networks' range. */
function widths({ of, stretch }: Parameters, prefix: string): { alpha: number; alphaV?: number } {
  const roughness = mean(of(`${prefix}_roughness`));
  const ratio = 1 - mean(of(`${prefix}_roughness_anisotropy`));
  const along = roughness ** 2 * stretch(Math.max(ratio, 0.02));
  const clipped = (width: number) => Math.min(Math.max(width, CHECKS.MIN_ALPHA), 1);
  const alpha = clipped(along);
  return ratio === 1 ? { alpha } : { alpha, alphaV: clipped(ratio * along) };
}

/** The constant value of an input in linear sRGB. */
function constantOf(input: Element, name: string): Channels {
  const text = input.getAttribute("value") ?? "";
  const numbers = text === "true" ? [1] : text === "false" ? [0] : text.split(",").map(Number);
  if (![1, 3].includes(numbers.length) || text.trim() === "" || !numbers.every(Number.isFinite))
    throw new Refusal(`Its input ${name} is neither a number nor a colour.`);
  if (numbers.length === 1) return numbers[0]!;
  const space = input.closest("[colorspace]")?.getAttribute("colorspace") ?? "lin_rec709";
  const colour = numbers as unknown as Rgb;
  if (space === "lin_rec709" || space === "lin_rec709_scene" || space === "") return joined(colour);
  if (space !== "srgb_texture")
    throw new Refusal(`Its input ${name} is in the colour space ${space}; ${CONVERT}`);
  return mapped(joined(colour), (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4));
}

function mean(value: Channels): number {
  const [red, green, blue] = rgb(value);
  return (red + green + blue) / 3;
}
