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
  const lines = [
    "import numpy as np",
    "",
    "import urushi",
    "",
    "# The layers one by one by the layering network, as on the page. Without fast=True, light",
    "# transport is computed, which takes longer and is closer to the random walk.",
    `material = ${bottomText(stack.bottom, isBare && isCompensated(material))}`,
  ];
  for (const [place, coat] of [...stack.coats.entries()].reverse()) {
    const top = call("urushi.dielectric", [...widthsOf(coat), ["ior", coat.ior]]);
    const others: [string, Channels | string][] = mediumParameters(coat);
    if (place === 0 && isCompensated(material)) others.push(["energy_compensation", "True"]);
    // One network layers all coats.
    const isLowest = place === stack.coats.length - 1;
    if (isLowest && isAnisotropic(stack)) others.push(["weights", '"anisotropic"']);
    others.push(["fast", "True"]);
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

/** The medium of a coat as it was given, by its parameters in Python. */
export function mediumParameters(coat: CoatInAir): [string, Channels][] {
  const medium: [string, Channels][] =
    "sigmaT" in coat
      ? [
          ["albedo", coat.albedo],
          ["sigma_t", coat.sigmaT],
        ]
      : [
          ["color", coat.color],
          ["body", coat.body],
          ["body_color", coat.bodyColor],
        ];
  const { g, thickness = 1 } = coat;
  return [
    ...medium,
    ["g", g],
    ...(thickness === 1 ? [] : [["thickness", thickness] as [string, number]]),
  ];
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

function bottomText(bottom: BottomInAir, isGiven: boolean): string {
  const given = isGiven ? [["energy_compensation", "True"] as const] : [];
  switch (bottom.kind) {
    case "conductor": {
      const facets: [string, Channels][] =
        "r0" in bottom
          ? [["r0", bottom.r0]]
          : [
              ["eta", bottom.eta],
              ["k", bottom.k],
            ];
      return call("urushi.conductor", [...widthsOf(bottom), ...facets, ...given]);
    }
    case "dielectric":
      return call("urushi.dielectric", [...widthsOf(bottom), ["ior", bottom.ior]]);
    case "diffuse":
      return call("urushi.diffuse", [["reflectance", bottom.reflectance]]);
    case "codes":
      throw new Refusal(
        "A loaded material cannot be written as a description; save the state as JSON.",
      );
  }
}

/** The widths of a surface. */
export function widthsOf(surface: { alpha: Channels; alphaV?: Channels }): [string, Channels][] {
  const { alpha, alphaV } = surface;
  if (alphaV === undefined) return [["alpha", alpha]];
  return [
    ["alpha_u", alpha],
    ["alpha_v", alphaV],
  ];
}

function call(
  name: string,
  parameters: readonly (readonly [string, Channels | string])[],
  first = "",
): string {
  const named = parameters.map(([key, value]) => `${key}=${python(value)}`);
  return `${name}(${[...(first ? [first] : []), ...named].join(", ")})`;
}

/** "0.1" or "(0.1, 0.2, 0.3)". */
function python(value: Channels | string): string {
  return typeof value !== "object" ? String(value) : `(${value.join(", ")})`;
}
