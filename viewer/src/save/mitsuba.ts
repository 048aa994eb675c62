/** A material as a BSDF of Mitsuba 3, in XML. */

import {
  type BottomInAir,
  type CoatInAir,
  isAnisotropic,
  isCompensated,
  type MaterialCards,
  seenOf,
} from "../material/material";
import { Refusal } from "../refusal";
import { type Parameter, parametersOf, surfaceOf } from "./python";

/** A plugin of a scene and its parameters in their order. */
type Plugin = [type: string, values: Parameter[]];

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
  if (isCompensated(material)) layers[0][1].push(["energy_compensation", true]);
  if (isTurned) layers[0][1].push(["rotation", rotation]);
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
  const named = ([name, value]: Parameter): Parameter => [name === "ior" ? "int_ior" : name, value];
  return ["neural_layered", parametersOf(coat).map(named)];
}

function bottomOf(bottom: BottomInAir): Plugin {
  const values = surfaceOf(bottom);
  if (bottom.kind === "diffuse") return ["diffuse", values];
  if (bottom.kind === "dielectric")
    throw new Refusal("Mitsuba has no opaque dielectric; choose another bottom.");
  // Mitsuba has no Schlick's term: the reflectance is that of normal incidence throughout.
  const metal = values.flatMap(([name, value]): Parameter[] =>
    name === "r0"
      ? [
          ["material", "none"],
          ["specular_reflectance", value],
        ]
      : [[name, value]],
  );
  return ["roughconductor", [["distribution", "ggx"], ...metal]];
}

/** The element of Mitsuba's XML; it reads some parameters as colours, whether one number or three. */
function elementOf(name: string, value: Parameter[1]) {
  if (typeof value === "string") return "string";
  if (value === true) return "boolean";
  const isColour = ["reflectance", "specular_reflectance", "k", "eta"].includes(name);
  return typeof value === "number" && !isColour ? "float" : "rgb";
}
