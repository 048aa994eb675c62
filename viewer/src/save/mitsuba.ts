/** A material as a BSDF of Mitsuba 3: XML, and a dictionary of Python. */

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

/** A node of a scene: a plugin, its parameters in their order, and the BSDF inside. */
interface Node {
  type: string;
  values: [name: string, value: Channels | string | true][];
  inner: Node | null;
}

/**
 * The BSDF as XML.
 *
 * @throws Refusal if Mitsuba has no such BSDF.
 */
export function mitsubaXml(material: MaterialCards): string {
  return `${xmlLines(nodeOf(material), 0, "material").join("\n")}\n`;
}

/** The BSDF as a dictionary for `mi.load_dict`; as `mitsubaXml`. */
export function mitsubaDict(material: MaterialCards): string {
  const lines = dictLines(nodeOf(material), 0);
  return `import urushi  # registers the plugin\n\nbsdf = ${lines.join("\n").trimStart()}\n`;
}

function nodeOf(material: MaterialCards): Node {
  const { rotation = 0 } = material;
  const stack = seenOf(material);
  const node = stack.coats.reduceRight<Node>(
    (inner, coat) => coatNode(coat, inner),
    bottomNode(stack.bottom),
  );
  if (isCompensated(material)) node.values.unshift(["energy_compensation", true]);
  if (!isAnisotropic(stack) || rotation === 0) return node;
  if (stack.coats.length === 0)
    throw new Refusal(
      "Mitsuba turns no tangent of a bare surface; set the angle to 0, or save the material.",
    );
  node.values.push(["rotation", rotation]);
  return node;
}

function coatNode(coat: CoatInAir, inner: Node): Node {
  const values: Node["values"] = [...widthsOf(coat), ["int_ior", coat.ior]];
  return { type: "neural_layered", values: [...values, ...mediumParameters(coat)], inner };
}

function bottomNode(bottom: BottomInAir): Node {
  switch (bottom.kind) {
    case "conductor": {
      // Mitsuba has no Schlick's term: the reflectance is that of normal incidence throughout.
      const values: Node["values"] =
        "r0" in bottom
          ? [["material", "none"], ...widthsOf(bottom), ["specular_reflectance", bottom.r0]]
          : [...widthsOf(bottom), ["eta", bottom.eta], ["k", bottom.k]];
      return { type: "roughconductor", values: [["distribution", "ggx"], ...values], inner: null };
    }
    case "diffuse":
      return { type: "diffuse", values: [["reflectance", bottom.reflectance]], inner: null };
    case "dielectric":
      throw new Refusal("Mitsuba has no opaque dielectric; choose another bottom.");
    case "codes":
      throw new Refusal(
        "A loaded material is rendered from its own file, by the plugin neural_brdf.",
      );
  }
}

function xmlLines({ type, values, inner }: Node, depth: number, id: string | null): string[] {
  const indent = "    ".repeat(depth);
  const lines = values.map(([name, value]) => {
    const text = typeof value === "object" ? value.join(", ") : value;
    return `${indent}    <${elementOf(name, value)} name="${name}" value="${text}"/>`;
  });
  const named = id === null ? ' name="bottom"' : ` id="${id}"`;
  if (inner !== null) lines.push(...xmlLines(inner, depth + 1, null));
  return [`${indent}<bsdf type="${type}"${named}>`, ...lines, `${indent}</bsdf>`];
}

function dictLines({ type, values, inner }: Node, depth: number): string[] {
  const indent = "    ".repeat(depth + 1);
  const lines = values.map(([name, value]) => {
    const numbers = typeof value === "object" ? value.join(", ") : value;
    const text = {
      string: `"${value}"`,
      boolean: "True",
      float: value,
      rgb: `{"type": "rgb", "value": [${numbers}]}`,
    }[elementOf(name, value)];
    return `${indent}"${name}": ${text},`;
  });
  if (inner !== null) {
    const [first, ...rest] = dictLines(inner, depth + 1);
    lines.push(`${indent}"bottom": ${first!.trimStart()}`, ...rest);
    lines[lines.length - 1] += ",";
  }
  const outer = "    ".repeat(depth);
  return [`${outer}{`, `${indent}"type": "${type}",`, ...lines, `${outer}}`];
}

/** The element of Mitsuba's XML; it reads some parameters as colours, whether one number or three. */
function elementOf(name: string, value: Channels | string | true) {
  if (typeof value === "string") return "string";
  if (value === true) return "boolean";
  const isColour = ["reflectance", "specular_reflectance", "k", "eta"].includes(name);
  return typeof value === "number" && !isColour ? "float" : "rgb";
}
