/** A material as a BSDF of Mitsuba 3, in XML. */

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
import { mediumParameters, widthsOf } from "./python";

/** A plugin of a scene and its parameters in their order. */
type Plugin = [type: string, values: [name: string, value: Channels | string | true][]];

/**
 * The BSDF as XML, each layer inside of the one above.
 *
 * @throws Refusal if Mitsuba has no such BSDF.
 */
export function mitsubaXml(material: MaterialCards): string {
  const { rotation = 0 } = material;
  const stack = seenOf(material);
  const isTurned = isAnisotropic(stack) && rotation !== 0;
  if (isTurned && stack.coats.length === 0)
    throw new Refusal(
      "Mitsuba turns no tangent of a bare surface; set the angle to 0, or save the material.",
    );
  if (isCompensated(material) && stack.coats.length === 0)
    throw new Refusal(
      "Mitsuba has no bare metal with energy compensation; switch that off, or save the material.",
    );
  const layers: Plugin[] = [...stack.coats.map(pluginOf), bottomOf(stack.bottom)];
  if (isCompensated(material)) layers[0]![1].push(["energy_compensation", true]);
  if (isTurned) layers[0]![1].push(["rotation", rotation]);
  const lines = layers.flatMap(([type, values], depth) => {
    const head = `<bsdf type="${type}" ${depth === 0 ? 'id="material"' : 'name="bottom"'}>`;
    const inner = values.map(([name, value]) => {
      const text = typeof value === "object" ? value.join(", ") : value;
      return `    <${elementOf(name, value)} name="${name}" value="${text}"/>`;
    });
    return [head, ...inner].map((line) => "    ".repeat(depth) + line);
  });
  const ends = layers.map((_, depth) => `${"    ".repeat(depth)}</bsdf>`).reverse();
  return `${[...lines, ...ends].join("\n")}\n`;
}

function pluginOf(coat: CoatInAir): Plugin {
  return ["neural_layered", [...widthsOf(coat), ["int_ior", coat.ior], ...mediumParameters(coat)]];
}

function bottomOf(bottom: BottomInAir): Plugin {
  switch (bottom.kind) {
    case "conductor": {
      // Mitsuba has no Schlick's term: the reflectance is that of normal incidence throughout.
      const values: Plugin[1] =
        "r0" in bottom
          ? [["material", "none"], ...widthsOf(bottom), ["specular_reflectance", bottom.r0]]
          : [...widthsOf(bottom), ["eta", bottom.eta], ["k", bottom.k]];
      return ["roughconductor", [["distribution", "ggx"], ...values]];
    }
    case "diffuse":
      return ["diffuse", [["reflectance", bottom.reflectance]]];
    case "dielectric":
      throw new Refusal("Mitsuba has no opaque dielectric; choose another bottom.");
    case "codes":
      throw new Refusal(
        "A loaded material is rendered from its own file, by the plugin neural_brdf.",
      );
  }
}

/** The element of Mitsuba's XML; it reads some parameters as colours, whether one number or three. */
function elementOf(name: string, value: Channels | string | true) {
  if (typeof value === "string") return "string";
  if (value === true) return "boolean";
  const isColour = ["reflectance", "specular_reflectance", "k", "eta"].includes(name);
  return typeof value === "number" && !isColour ? "float" : "rgb";
}
