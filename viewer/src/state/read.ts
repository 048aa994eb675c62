/** Reading a state from JSON that may be anything: checked, with one sentence on what is wrong. */

import type { Channels } from "../core/api";
import { mapped, rgb } from "../material/channels";
import {
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
import {
  COMPARISONS,
  DIFFERENCE_SCALES,
  ENVIRONMENTS,
  INITIAL,
  OBJECTS,
  type State,
  TONES,
} from "./state";

type Fields = Record<string, unknown>;

/** The state of a JSON value; fields that are missing have their first values. */
export function readState(value: unknown): State {
  const fields = object(value, "the state");
  const materials = fields.materials;
  if (!Array.isArray(materials) || materials.length < 1 || materials.length > 2)
    throw new Refusal("The state has no materials.");
  const first = readMaterial(materials[0]);
  const second = materials.length > 1 ? readMaterial(materials[1]) : INITIAL.materials[1];
  const view = object(fields.view ?? {}, "the view");
  const pan = Array.isArray(view.pan) ? view.pan : [];
  const { background } = fields;
  return {
    materials: [first, second],
    active: fields.active === 1 ? 1 : 0,
    comparison: choice(fields.comparison, COMPARISONS, INITIAL.comparison),
    edge: number(fields.edge, 0, 1, INITIAL.edge),
    scale: choice(fields.scale, DIFFERENCE_SCALES, INITIAL.scale),
    object: choice(fields.object, [...OBJECTS, "own"] as const, INITIAL.object),
    mesh: nameOf(fields.mesh, INITIAL.mesh),
    environment: choice(fields.environment, ENVIRONMENTS, INITIAL.environment),
    panorama: nameOf(fields.panorama, INITIAL.panorama),
    rotation: number(fields.rotation, -180, 180, INITIAL.rotation),
    exposure: number(fields.exposure, -6, 6, INITIAL.exposure),
    view: {
      azimuth: number(view.azimuth, -180, 180, INITIAL.view.azimuth),
      elevation: number(view.elevation, -10, 85, INITIAL.view.elevation),
      zoom: number(view.zoom, 0.5, 4, INITIAL.view.zoom),
      fov: number(view.fov, 5, 60, INITIAL.view.fov),
      pan: [number(pan[0], -2, 2, 0), number(pan[1], -2, 2, 0)],
    },
    tone: choice(fields.tone, TONES, INITIAL.tone),
    background:
      background === "transparent" || /^#[0-9a-f]{6}$/.test(String(background))
        ? String(background)
        : INITIAL.background,
    turntable: fields.turntable === true,
    plots: fields.plots === true,
    incidence: number(fields.incidence, 0, 89, INITIAL.incidence),
  };
}

/** The material of a JSON value. */
export function readMaterial(value: unknown): MaterialCards {
  const fields = object(value, "the material");
  const coats = fields.coats ?? [];
  if (!Array.isArray(coats) || coats.length > MOST_COATS)
    throw new Refusal(`A material has at most ${MOST_COATS} coats.`);
  const bottom = readBottom(fields.bottom);
  if (bottom.kind === "texels" && coats.length > 0)
    throw new Refusal("A texture of codes cannot be coated on this page.");
  const solo = fields.solo;
  return {
    name: nameOf(fields.name, "Material"),
    bottom,
    coats: coats.map(readCoat),
    ...(fields.energyCompensation === true ? { energyCompensation: true } : {}),
    ...(fields.rotation === undefined ? {} : { rotation: number(fields.rotation, -180, 180, 0) }),
    solo:
      typeof solo === "number" && Number.isInteger(solo) && solo >= 0 && solo <= coats.length
        ? solo
        : null,
  };
}

function readCoat(value: unknown, place: number): CoatCard {
  const fields = object(value, "a coat");
  const one = (name: keyof typeof COAT_PARAMETERS) =>
    channels(fields[name], COAT_PARAMETERS[name], name);
  const medium = ["albedo", "sigmaT"].some((name) => name in fields)
    ? { albedo: one("albedo"), sigmaT: one("sigmaT") }
    : { color: one("color"), body: one("body"), bodyColor: one("bodyColor") };
  const thickness = rgb(one("thickness"))[0];
  return {
    id: place + 1,
    on: fields.on !== false,
    ...widths(fields, one("alpha")),
    ior: one("ior"),
    ...medium,
    g: one("g"),
    ...(thickness === 1 ? {} : { thickness }),
  };
}

function readBottom(value: unknown): BottomInAir | TexelBottom {
  const fields = object(value, "the bottom");
  const one = (name: keyof typeof BOTTOM_PARAMETERS) =>
    channels(fields[name], BOTTOM_PARAMETERS[name], name);
  switch (fields.kind) {
    case "conductor": {
      const facets = "r0" in fields ? { r0: one("r0") } : { eta: one("eta"), k: one("k") };
      return { kind: "conductor", ...widths(fields, one("alpha")), ...facets };
    }
    case "dielectric":
      return { kind: "dielectric", ...widths(fields, one("alpha")), ior: one("ior") };
    case "diffuse":
      return { kind: "diffuse", reflectance: one("reflectance") };
    case "codes":
      return {
        kind: "codes",
        latents: codes(fields.latents),
        ...(fields.widths === 2 ? { widths: 2 } : {}),
        ...(fields.table === undefined ? {} : { table: checkSum(fields.table, "table") }),
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
function widths(fields: Fields, alpha: Channels): { alpha: Channels; alphaV?: Channels } {
  const across = fields.alphaV;
  if (across === undefined) return { alpha };
  return { alpha, alphaV: channels(across, COAT_PARAMETERS.alpha, "alphaV") };
}

function object(value: unknown, what: string): Fields {
  if (typeof value !== "object" || value === null || Array.isArray(value))
    throw new Refusal(`There is no description of ${what}.`);
  return value as Fields;
}

function channels(value: unknown, parameter: Parameter, name: string): Channels {
  if (value === undefined) return parameter.fallback;
  const numbers = Array.isArray(value) ? value : [value];
  const whole = numbers.length === 1 || numbers.length === 3;
  if (!whole || !numbers.every((x) => typeof x === "number" && Number.isFinite(x)))
    throw new Refusal(`The parameter ${name} is neither a number nor three.`);
  return mapped(numbers.length === 1 ? numbers[0] : (value as [number, number, number]), (x) =>
    clamped(parameter, x),
  );
}

function codes(value: unknown): Float32Array {
  const fine = Array.isArray(value) && value.length > 0 && value.length <= 768;
  if (!fine || value.length % 3 || !value.every((x) => typeof x === "number" && Number.isFinite(x)))
    throw new Refusal("The codes of the bottom are damaged.");
  return new Float32Array(value);
}

function number(value: unknown, low: number, high: number, fallback: number): number {
  if (typeof value !== "number" || !Number.isFinite(value)) return fallback;
  return Math.min(Math.max(value, low), high);
}

function nameOf(value: unknown, fallback: string): string {
  return (typeof value === "string" && value.trim().slice(0, 80)) || fallback;
}

function choice<T>(value: unknown, all: readonly T[], fallback: T): T {
  return all.find((one) => one === value) ?? fallback;
}
