/** The material on the page: cards of coats over a bottom, and the stack that they describe. */

import type { Bottom, Channels, Coat, Stack } from "../core/api";
import { Refusal } from "../refusal";

export type Rgb = readonly [number, number, number];

/** One coat on the page. */
export interface CoatCard extends Coat {
  /** Identifies the card while it moves; above 0. */
  id: number;
  /** Whether the coat is part of the picture. */
  on: boolean;
}

/** A texture of codes, named by its `CodeTexture.id`: its texels are no part of the state. */
export interface TexelBottom {
  kind: "texels";
  texture: string;
}

/** A named stack of cards. */
export interface MaterialCards {
  name: string;
  /** A texture of codes has no coats. */
  bottom: Bottom | TexelBottom;
  /** The topmost first. */
  coats: readonly CoatCard[];
  /** Angle by which the tangent of all layers is turned [degrees]; 0 if left out. */
  rotation?: number;
  /** The only coat that is shown, by its id; `BARE`: none; null: all that are on. */
  solo: number | null;
}

/** `MaterialCards.solo` of the bottom: it is shown without coats. */
export const BARE = 0;

export const MOST_COATS = 6;

/** A clear coat of glass, as Urushi's default. */
const CLEAR_COAT: Coat = { alpha: 0.1, eta: 1.5, albedo: 0, sigmaT: 0, g: 0 };

/** Whether a coat is part of the picture. */
export function isSeen(material: MaterialCards, coat: CoatCard): boolean {
  return material.solo === null ? coat.on : material.solo === coat.id;
}

/**
 * The stack that is shown.
 *
 * @throws Refusal if it is a texture of codes.
 */
export function stackOf(material: MaterialCards): Stack {
  const { bottom } = material;
  if (bottom.kind === "texels")
    throw new Refusal("A texture of codes can be saved as a material file or a Mitsuba scene.");
  const coats = material.coats.filter((coat) => isSeen(material, coat));
  return {
    bottom,
    coats: coats.map(({ alpha, alphaV, eta, albedo, sigmaT, g }) => ({
      alpha,
      ...(alphaV === undefined ? {} : { alphaV }),
      eta,
      albedo,
      sigmaT,
      g,
    })),
  };
}

/** The largest ratio of a surface's two widths; 1 if it has one. */
export function widthRatio(surface: Coat | Bottom): number {
  if (!("alpha" in surface) || surface.alphaV === undefined) return 1;
  const across = rgb(surface.alphaV);
  const ratios = rgb(surface.alpha).map((width, channel) => width / across[channel]!);
  return Math.max(...ratios, ...ratios.map((ratio) => 1 / ratio));
}

/** Whether a card has two widths, equal or not, or the loaded codes may have. */
export function hasTangent({ bottom, coats }: MaterialCards): boolean {
  if (bottom.kind === "codes" && bottom.widths === 2) return true;
  return [bottom, ...coats].some((surface) => "alphaV" in surface);
}

/** Whether a stack needs the networks for anisotropic materials. */
export function isAnisotropic({ bottom, coats }: Stack): boolean {
  const isOfCodes = bottom.kind === "codes" && bottom.widths === 2;
  return isOfCodes || [bottom, ...coats].some((surface) => widthRatio(surface) !== 1);
}

/** Whether another coat can be added. */
export function takesCoat({ bottom, coats }: MaterialCards): boolean {
  return bottom.kind !== "texels" && coats.length < MOST_COATS;
}

/** A number for an additional card. */
function freeId(material: MaterialCards): number {
  return Math.max(0, ...material.coats.map((coat) => coat.id)) + 1;
}

/** Three numbers, from one for all channels or three. */
export function rgb(value: Channels): Rgb {
  return typeof value === "number" ? [value, value, value] : value;
}

/** One number if all three agree, otherwise the three. */
export function joined(value: Rgb): Channels {
  return value[0] === value[1] && value[1] === value[2] ? value[0] : value;
}

/** The material with a card moved to another place. */
export function moved(material: MaterialCards, from: number, to: number): MaterialCards {
  const coats = [...material.coats];
  const [card] = coats.splice(from, 1);
  if (card === undefined) return material;
  coats.splice(Math.max(0, Math.min(to, coats.length)), 0, card);
  return { ...material, coats };
}

/** The material with a coat on top of all others. */
export function withCoat(material: MaterialCards, coat: Coat = CLEAR_COAT): MaterialCards {
  if (!takesCoat(material)) return material;
  const card: CoatCard = { ...coat, id: freeId(material), on: true };
  return { ...material, coats: [card, ...material.coats] };
}

/** The material without a coat. */
export function withoutCoat(material: MaterialCards, id: number): MaterialCards {
  return {
    ...material,
    coats: material.coats.filter((coat) => coat.id !== id),
    solo: material.solo === id ? null : material.solo,
  };
}
