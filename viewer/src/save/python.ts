/** A material as a Python program. */

import type { Channels } from "../core/api";
import {
  type BottomInAir,
  type CoatInAir,
  isAnisotropic,
  isCompensated,
  type MaterialCards,
  seenOf,
} from "../material/material";
import { Refusal } from "../refusal";

/** A program that encodes the bottom, layers the coats as the page does, and saves the material. */
export function pythonText(material: MaterialCards): string {
  const { name, rotation = 0 } = material;
  const stack = seenOf(material);
  const isBare = stack.coats.length === 0;
  const bottom = surfaceOf(stack.bottom);
  if (isBare && isCompensated(material)) bottom.push(["energy_compensation", true]);
  const lines = [
    "import numpy as np",
    "",
    "import urushi",
    "",
    "# The layers one by one by the layering network, as on the page. Without fast=True, light",
    "# transport is computed, which takes longer and is closer to the random walk.",
    `material = ${call(`urushi.${stack.bottom.kind}`, bottom)}`,
  ];
  for (const [place, coat] of [...stack.coats.entries()].reverse()) {
    const isOfSurface = ([name]: Parameter) => name === "ior" || name.startsWith("alpha");
    const all = parametersOf(coat);
    const top = call("urushi.dielectric", all.filter(isOfSurface));
    const others = all.filter((parameter) => !isOfSurface(parameter));
    if (place === 0 && isCompensated(material)) others.push(["energy_compensation", true]);
    // One network layers all coats.
    const isLowest = place === stack.coats.length - 1;
    if (isLowest && isAnisotropic(stack)) others.push(["weights", '"anisotropic"']);
    others.push(["fast", true]);
    lines.push(`material = ${call("urushi.layer", others, `${top}, material`)}`);
  }
  if (isBare) lines.push("material = urushi.encode(material)");
  const turned = rotation !== 0 && isAnisotropic(stack) ? `material.rotated(${rotation})` : "";
  const direction = "np.array([[0.5, 0.0, np.sqrt(0.75)]])";
  lines.push(
    ...(turned ? [`material = ${turned}`] : []),
    "",
    `print(material.f(${direction}, ${direction} * [-1, 1, 1]))  # 1/sr`,
    `material.save("${fileName(name)}.safetensors")`,
    "",
  );
  return lines.join("\n");
}

/** A parameter by its name in Python; true: it is switched on. */
export type Parameter = [name: string, value: Channels | string | true];

/** Parameters of layers, in the order in which they are written. */
const ORDER =
  "alpha alphaU alphaV ior r0 eta k reflectance albedo sigmaT color body bodyColor g thickness".split(
    " ",
  );

/** The parameters of a coat or a bottom, as they were given. */
export function parametersOf(layer: CoatInAir | BottomInAir): Parameter[] {
  const { alpha, ...others } = { thickness: 1, ...layer } as Record<string, Channels>;
  const given = { ...others, ["alphaV" in layer ? "alphaU" : "alpha"]: alpha };
  const names = ORDER.filter((name) => given[name] !== undefined);
  return names
    .filter((name) => name !== "thickness" || given.thickness !== 1)
    .map((name) => [name.replace(/[A-Z]/, (letter) => `_${letter.toLowerCase()}`), given[name]]);
}

/** The name of a file for a material. */
export function fileName(name: string): string {
  return (
    name
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-|-$/g, "") || "material"
  );
}

/**
 * The parameters of a bottom.
 *
 * @throws Refusal if it is a loaded one.
 */
export function surfaceOf(bottom: BottomInAir): Parameter[] {
  if (bottom.kind === "codes")
    throw new Refusal("A loaded material has no description; save its file, or the state as JSON.");
  return parametersOf(bottom);
}

function call(name: string, parameters: readonly Parameter[], first = ""): string {
  const named = parameters.map(([key, value]) => `${key}=${python(value)}`);
  return `${name}(${[...(first ? [first] : []), ...named].join(", ")})`;
}

/** "0.1" or "(0.1, 0.2, 0.3)". */
function python(value: Parameter[1]): string {
  if (value === true) return "True";
  return typeof value !== "object" ? String(value) : `(${value.join(", ")})`;
}
