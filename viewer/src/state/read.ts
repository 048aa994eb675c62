/** Reading a state from JSON that may be anything: checked, with one sentence on what is wrong. */

import type { Channels } from "../core/api";
import { mapped, rgb } from "../material/channels";
import {
  BARE,
  type BottomInAir,
  type CoatCard,
  type MaterialCards,
  MOST_COATS,
  type TexelBottom,
} from "../material/material";
import {
  BOTTOM_PARAMETERS,
  COAT_PARAMETERS,
  clamped,
  type Parameter,
} from "../material/parameters";
import { Refusal } from "../refusal";
import { type Fields, object, text, within } from "./json";
import { INITIAL, readFields, type State } from "./state";

/** The state of a JSON value; fields that are missing have their first values. */
export function readState(value: unknown): State {
  const { materials } = object(value, "the state");
  if (!Array.isArray(materials) || materials.length < 1 || materials.length > 2)
    throw new Refusal("The state has no materials.");
  const [first, second = INITIAL.materials[1]] = materials.map(readMaterial);
  return { materials: [first!, second], ...readFields(value) };
}

/** The material of a JSON value. */
export function readMaterial(value: unknown): MaterialCards {
  const fields = object(value, "the material");
  const { coats = [], solo } = fields;
  if (!Array.isArray(coats) || coats.length > MOST_COATS)
    throw new Refusal(`A material has at most ${MOST_COATS} coats.`);
  const bottom = readBottom(fields.bottom);
  if (bottom.kind === "texels" && coats.length > 0)
    throw new Refusal("A texture of codes cannot be coated on this page.");
  return {
    name: text("Material")(fields.name),
    bottom,
    coats: coats.map(readCoat),
    ...(fields.energyCompensation === true ? { energyCompensation: true } : {}),
    ...("rotation" in fields ? { rotation: within(-180, 180, 0)(fields.rotation) } : {}),
    solo: solo === BARE ? BARE : idOf(coats, solo),
  };
}

/** The id that the coat of another id gets when it is read; null: there is none. */
function idOf(coats: readonly unknown[], id: unknown): number | null {
  const place = coats.findIndex((coat, place) => (Object(coat).id ?? place + 1) === id);
  return place < 0 ? null : place + 1;
}

function readCoat(value: unknown, place: number): CoatCard {
  const fields = object(value, "a coat");
  const given = numbersOf(fields, COAT_PARAMETERS);
  const medium =
    "albedo" in fields || "sigmaT" in fields
      ? given("albedo", "sigmaT")
      : given("color", "body", "bodyColor");
  const thickness = rgb(given("thickness").thickness)[0];
  return {
    id: place + 1,
    on: fields.on !== false,
    ...widths(fields, COAT_PARAMETERS),
    ...given("ior", "g"),
    ...medium,
    ...(thickness === 1 ? {} : { thickness }),
  };
}

function readBottom(value: unknown): BottomInAir | TexelBottom {
  const fields = object(value, "the bottom");
  const given = numbersOf(fields, BOTTOM_PARAMETERS);
  const surface = () => widths(fields, BOTTOM_PARAMETERS);
  switch (fields.kind) {
    case "conductor": {
      const facets = "r0" in fields ? given("r0") : given("eta", "k");
      return { kind: "conductor", ...surface(), ...facets };
    }
    case "dielectric":
      return { kind: "dielectric", ...surface(), ...given("ior") };
    case "diffuse":
      return { kind: "diffuse", ...given("reflectance") };
    case "codes":
      return {
        kind: "codes",
        latents: codes(fields.latents),
        ...(fields.widths === 2 ? { widths: 2 } : {}),
        ...("table" in fields ? { table: checkSum(fields.table, "table") } : {}),
        ...(fields.besideLobe === true ? { besideLobe: true } : {}),
      };
    case "texels":
      return { kind: "texels", texture: checkSum(fields.texture, "texture") };
    default:
      throw new Refusal("The bottom is of no kind that this page knows.");
  }
}

/** The check sum that names what is no part of the state. */
function checkSum(value: unknown, what: string): string {
  if (typeof value !== "string" || !/^[0-9a-f]{8}$/.test(value))
    throw new Refusal(`The name of the bottom's ${what} is damaged.`);
  return value;
}

/** The widths of a surface; one across the tangent only if it is given. */
function widths(fields: Fields, { alpha }: { alpha: Parameter }) {
  const given = numbersOf(fields, { alpha, alphaV: alpha });
  return "alphaV" in fields ? given("alpha", "alphaV") : given("alpha");
}

/** A function that reads parameters, each one number for all channels or three, within its range. */
function numbersOf<Known extends string>(fields: Fields, parameters: Record<Known, Parameter>) {
  const one = (name: Known): Channels => {
    const { [name]: value = parameters[name].fallback } = fields;
    const all = [value].flat();
    if (![1, 3].includes(all.length) || !all.every(Number.isFinite))
      throw new Refusal(`The parameter ${name} is neither a number nor three.`);
    return mapped((all.length === 1 ? all[0] : all) as Channels, (x) =>
      clamped(parameters[name], x),
    );
  };
  return <Name extends Known>(...names: Name[]) =>
    Object.fromEntries(names.map((name) => [name, one(name)])) as Record<Name, Channels>;
}

function codes(value: unknown): Float32Array {
  const fine = Array.isArray(value) && value.length > 0 && value.length <= 768;
  if (!fine || value.length % 3 || !value.every(Number.isFinite))
    throw new Refusal("The codes of the bottom are damaged.");
  return new Float32Array(value);
}
