/** A material as a Python program. */

import type { Bottom, Channels, Stack } from "../core/api";
import { isAnisotropic } from "../material/material";
import { Refusal } from "../refusal";

/**
 * A program that encodes the bottom, layers the coats as the page does, and saves the material.
 *
 * @param rotation of the tangent [degrees].
 */
export function pythonText(stack: Stack, name: string, rotation = 0): string {
  const lines = [
    "import numpy as np",
    "",
    "import urushi",
    "",
    "# The layers one by one, as on the page. urushi.encode of a description by urushi.coat takes",
    "# longer and is closer to the random walk.",
    `material = urushi.encode(${bottomText(stack.bottom)}, refine=False)`,
  ];
  for (const coat of [...stack.coats].reverse()) {
    const { eta, albedo, sigmaT, g } = coat;
    const top = call("urushi.dielectric", [...widthsOf(coat), ["eta", eta]]);
    const medium: [string, Channels][] = [
      ["albedo", albedo],
      ["sigma_t", sigmaT],
      ["g", g],
    ];
    lines.push(`material = ${call("urushi.layer", medium, `${top}, material`)}`);
  }
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

/** The name of a file for a material. */
export function fileName(name: string): string {
  return (
    name
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-|-$/g, "") || "material"
  );
}

function bottomText(bottom: Bottom): string {
  switch (bottom.kind) {
    case "conductor":
      return "r0" in bottom
        ? call("urushi.conductor", [...widthsOf(bottom), ["r0", bottom.r0]])
        : call("urushi.conductor", [...widthsOf(bottom), ["eta", bottom.eta], ["k", bottom.k]]);
    case "dielectric":
      return call("urushi.dielectric", [...widthsOf(bottom), ["eta", bottom.eta]]);
    case "diffuse":
      return call("urushi.diffuse", [["reflectance", bottom.reflectance]]);
    case "codes":
      throw new Refusal(
        "A loaded material cannot be written as a description; save the state as JSON.",
      );
  }
}

/** The widths of a surface. */
function widthsOf(surface: { alpha: Channels; alphaV?: Channels }): [string, Channels][] {
  const { alpha, alphaV } = surface;
  if (alphaV === undefined) return [["alpha", alpha]];
  return [
    ["alpha_u", alpha],
    ["alpha_v", alphaV],
  ];
}

function call(name: string, parameters: [string, Channels][], first = ""): string {
  const named = parameters.map(([key, value]) => `${key}=${python(value)}`);
  return `${name}(${[...(first ? [first] : []), ...named].join(", ")})`;
}

/** "0.1" or "(0.1, 0.2, 0.3)". */
function python(value: Channels): string {
  return typeof value === "number" ? String(value) : `(${value.join(", ")})`;
}
