/** The material on the page: cards of coats over a bottom, and the stack that they describe. */

import type { Bottom, Channels, Coat, Stack } from "../core/api";
import { CHECKS, fresnel } from "../printed/formulas";
import { Refusal } from "../refusal";
import { type Medium, physicsOf } from "./appearance";
import { each, joined, mapped, quotient, type Rgb, rgb } from "./channels";

/** A coat by its absolute index of refraction, and by its medium as it was given. */
export type CoatInAir = Omit<Coat, "eta" | "albedo" | "sigmaT" | "g"> &
  Medium & {
    ior: Channels;
    /** Factor of the optical depth; 1 if left out. */
    thickness?: number;
  };

/** The widths of a surface. */
export interface Widths {
  alpha: Channels;
  /** Left out, or undefined, while the widths are linked. */
  alphaV?: Channels | undefined;
}

/** The widths of a surface; `alphaV` is left out while they are linked. */
export function widthsOf({ alpha, alphaV }: Widths): { alpha: Channels; alphaV?: Channels } {
  return alphaV === undefined ? { alpha } : { alpha, alphaV };
}

/** One coat on the page. */
export type CoatCard = CoatInAir & {
  /** Identifies the card while it moves; above 0. */
  id: number;
  /** Whether the coat is part of the picture. */
  on: boolean;
};

/** A texture of codes, named by its `CodeTexture.id`: its texels are no part of the state. */
export interface TexelBottom {
  kind: "texels";
  texture: string;
}

/** Codes of a material, and the name of the table by which it is shown without coats, if it has one. */
export type CodesBottom = Bottom & { kind: "codes" } & { table?: string; besideLobe?: boolean };

/** A bottom by its indices of refraction in air: that of a dielectric, or a metal's eta and k. */
export type BottomInAir =
  | Exclude<Bottom, { kind: "dielectric" | "codes" }>
  | CodesBottom
  | { kind: "dielectric"; alpha: Channels; alphaV?: Channels; ior: Channels };

/** A named stack of cards. */
export interface MaterialCards {
  name: string;
  /** A texture of codes has no coats. */
  bottom: BottomInAir | TexelBottom;
  /** The topmost first. */
  coats: readonly CoatCard[];
  /** Angle by which the tangent of all layers is turned [degrees]; 0 if left out. */
  rotation?: number;
  /** Whether light that the topmost surface loses is given back, if it can be, see `givesBack`. */
  energyCompensation?: boolean;
  /** The only coat that is shown, by its id; `BARE`: none; null: all that are on. */
  solo: number | null;
}

/** `MaterialCards.solo` of the bottom: it is shown without coats. */
export const BARE = 0;

export const MOST_COATS = 6;

/** A clear coat of glass, as Urushi's default. */
export const CLEAR_COAT: CoatInAir = {
  alpha: 0.1,
  ior: 1.5,
  color: 1,
  body: 0,
  bodyColor: 0.8,
  g: 0,
};

/** Whether a coat has a surface, below the coats that are shown: its index there is another. */
export function hasSurface(material: MaterialCards, { id }: CoatCard): boolean {
  const place = material.coats.findIndex((coat) => coat.id === id);
  const above = material.coats.slice(0, place).filter((coat) => isSeen(material, coat));
  const coats = [...above, material.coats[place]].map((coat) => ({ ...coat, on: true }));
  const { coats: shown } = stackOf({ ...material, coats, solo: null });
  return rgb(shown.at(-1)!.eta).some((ratio) => ratio !== 1);
}

/** About the reflectance of a bottom at normal incidence, with three digits. */
export function reflectanceOf(bottom: MaterialCards["bottom"]): Rgb {
  if ("reflectance" in bottom) return rgb(bottom.reflectance);
  if ("r0" in bottom) return rgb(bottom.r0);
  if (bottom.kind === "codes" || bottom.kind === "texels") return [0.5, 0.5, 0.5];
  const [eta, k] = "k" in bottom ? [rgb(bottom.eta), rgb(bottom.k)] : [rgb(bottom.ior), [0, 0, 0]];
  return each((at) => Number(fresnel(1, eta[at], k[at]).toFixed(3)));
}

/** Whether a coat is part of the picture. */
export function isSeen(material: MaterialCards, coat: CoatCard): boolean {
  return material.solo === null ? coat.on : material.solo === coat.id;
}

/**
 * The bottom and the coats that are shown, whose indices are the nearest that the networks know below
 * the medium above.
 *
 * @throws Refusal if it is a texture of codes.
 */
export function seenOf(material: MaterialCards): { bottom: BottomInAir; coats: CoatCard[] } {
  const { bottom } = material;
  if (bottom.kind === "texels")
    throw new Refusal("A texture of codes can be saved as a material file or a Mitsuba scene.");
  let above: Channels = CHECKS.AIR;
  const within = <Layer extends { ior: Channels }>(layer: Layer): Layer => {
    above = nearestIndex(layer.ior, above);
    return { ...layer, ior: above };
  };
  const coats = material.coats.filter((coat) => isSeen(material, coat)).map(within);
  return { bottom: bottom.kind === "dielectric" ? within(bottom) : bottom, coats };
}

/** The nearest index that is within the networks' range, relative to the medium above. */
function nearestIndex(ior: Channels, above: Channels): Channels {
  const [low, high] = CHECKS.ETA_RANGE;
  const [own, media] = [rgb(ior), rgb(above)];
  const nearest = each((k) => {
    const near = Math.min(Math.max(own[k], low * media[k]), high * media[k]);
    // Rounded towards the inside
    return near === own[k]
      ? near
      : Number((near * (near > own[k] ? 1 + 1e-6 : 1 - 1e-6)).toFixed(6));
  });
  return joined(nearest);
}

/**
 * The stack that is shown: every index relative to the medium above, as in Python's `walk.stack`.
 *
 * @throws Refusal if it is a texture of codes.
 */
export function stackOf(material: MaterialCards): Stack {
  const { bottom, coats: cards } = seenOf(material);
  let above: Channels = CHECKS.AIR;
  const coats = cards.map((card): Coat => {
    const { ior, g, thickness = 1 } = card;
    const eta = interfaceRatio(ior, above);
    above = ior;
    const { albedo, sigmaT } = physicsOf(card);
    const depth = mapped(sigmaT, (own) => own * thickness);
    return { ...widthsOf(card), eta, albedo, sigmaT: depth, g };
  });
  const under = bottomUnder(bottom, quotient(above, CHECKS.AIR));
  const shown = under.kind === "dielectric" ? interfaceOf(under) : under;
  return { bottom: shown, coats, energyCompensation: isCompensated(material) };
}

/** A bottom below a medium of an index relative to air, as it would be in air. */
export function bottomUnder(bottom: BottomInAir, index: Channels): BottomInAir {
  if (bottom.kind === "codes") return { ...bottom, latents: codesUnder(bottom.latents, index) };
  if (bottom.kind === "dielectric") return { ...bottom, ior: quotient(bottom.ior, index) };
  if (!("k" in bottom)) return bottom; // Schlick's and diffuse ones are the same everywhere
  return { ...bottom, eta: quotient(bottom.eta, index), k: quotient(bottom.k, index) };
}

function interfaceOf({ ior, ...surface }: BottomInAir & { kind: "dielectric" }): Bottom {
  return { ...surface, eta: interfaceRatio(ior, CHECKS.AIR) };
}

/** Codes below a medium: eta and k of a metal's lobe, which has a k, become relative to it. */
function codesUnder(codes: Float32Array, index: Channels): Float32Array {
  const size = codes.length / 3;
  return codes.map((number, at) => {
    const isIndex = at % size === 4 || at % size === 5;
    const channel = Math.floor(at / size);
    return isIndex && codes[channel * size + 5] > 0 ? number / rgb(index)[channel] : number;
  });
}

/** The index of an interface relative to the medium above. */
function interfaceRatio(ior: Channels, above: Channels): Channels {
  return mapped(quotient(ior, above), (ratio) =>
    Math.abs(ratio - 1) < CHECKS.MIN_INDEX_STEP ? 1 : ratio,
  );
}

/** The largest ratio of a surface's two widths; 1 if it has one. */
export function widthRatio(surface: CoatInAir | BottomInAir | Coat | Bottom): number {
  if (!("alpha" in surface) || surface.alphaV === undefined) return 1;
  const across = rgb(surface.alphaV);
  const ratios = rgb(surface.alpha).map((width, channel) => width / across[channel]);
  return Math.max(...ratios, ...ratios.map((ratio) => 1 / ratio));
}

/** Whether a card has two widths, equal or not, or the loaded codes may have. */
export function hasTangent({ bottom, coats }: MaterialCards): boolean {
  if (bottom.kind === "codes" && bottom.widths === 2) return true;
  return [bottom, ...coats].some((surface) => "alphaV" in surface);
}

/** Whether a stack needs the networks for anisotropic materials. */
export function isAnisotropic({ bottom, coats }: Stack | ReturnType<typeof seenOf>): boolean {
  const isOfCodes = bottom.kind === "codes" && bottom.widths === 2;
  return isOfCodes || [bottom, ...coats].some((surface) => widthRatio(surface) !== 1);
}

/** Whether the topmost surface that is shown can give light back: a coat's or a metal's of one width. */
export function givesBack(material: MaterialCards): boolean {
  const seen = seenOf(material);
  const isRough = seen.coats.length > 0 || seen.bottom.kind === "conductor";
  return isRough && !isAnisotropic(seen);
}

/** Whether light is given back. */
export function isCompensated(material: MaterialCards): boolean {
  return material.energyCompensation === true && givesBack(material);
}

/** Whether another coat can be added. */
export function takesCoat({ bottom, coats }: MaterialCards): boolean {
  return bottom.kind !== "texels" && coats.length < MOST_COATS;
}

/** The material with a card moved to another place. */
export function moved(material: MaterialCards, from: number, to: number): MaterialCards {
  const coats = [...material.coats];
  const [card] = coats.splice(from, 1);
  if (card === undefined) return material;
  coats.splice(Math.max(0, Math.min(to, coats.length)), 0, card);
  return { ...material, coats };
}

/** The material with a clear coat on top of all others, with the surface of the topmost. */
export function withCoat(material: MaterialCards): MaterialCards {
  if (!takesCoat(material)) return material;
  const { coats } = material;
  const top = coats[0] ?? CLEAR_COAT;
  const id = Math.max(0, ...coats.map((coat) => coat.id)) + 1;
  const coat = { ...CLEAR_COAT, ...widthsOf(top), ior: top.ior, id, on: true };
  return { ...material, coats: [coat, ...coats] };
}

/** The material without a coat. */
export function withoutCoat(material: MaterialCards, id: number): MaterialCards {
  return {
    ...material,
    coats: material.coats.filter((coat) => coat.id !== id),
    solo: material.solo === id ? null : material.solo,
  };
}
