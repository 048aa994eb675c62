/** A material as a BSDF of Mitsuba 3: XML, and a dictionary of Python. */

import type { Channels } from "../core/api";
import {
  type BottomInAir,
  type CoatInAir,
  isAnisotropic,
  type MaterialCards,
  seenOf,
} from "../material/material";
import { Refusal } from "../refusal";
import { mediumParameters } from "./python";

/** A node of a scene: a plugin, its parameters and the BSDF inside. */
interface Node {
  type: string;
  strings: [string, string][];
  /** Switches that are on. */
  switches?: string[];
  values: [string, Channels][];
  /** The name of the BSDF inside, and that. */
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
  if (material.energyCompensation === true && stack.coats.length > 0)
    node.switches = ["energy_compensation"];
  if (!isAnisotropic(stack) || rotation === 0) return node;
  if (stack.coats.length === 0)
    throw new Refusal(
      "Mitsuba turns no tangent of a bare surface; set the angle to 0, or save the material.",
    );
  node.values.push(["rotation", rotation]);
  return node;
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

function coatNode(coat: CoatInAir, inner: Node): Node {
  return {
    type: "neural_layered",
    strings: [],
    values: [...widthsOf(coat), ["int_ior", coat.ior], ...mediumParameters(coat)],
    inner,
  };
}

function bottomNode(bottom: BottomInAir): Node {
  const ggx: [string, string] = ["distribution", "ggx"];
  switch (bottom.kind) {
    case "conductor":
      if ("r0" in bottom) {
        // Mitsuba has no Schlick's term: the reflectance is that of normal incidence throughout.
        const values: [string, Channels][] = [
          ...widthsOf(bottom),
          ["specular_reflectance", bottom.r0],
        ];
        return {
          type: "roughconductor",
          strings: [ggx, ["material", "none"]],
          values,
          inner: null,
        };
      }
      return {
        type: "roughconductor",
        strings: [ggx],
        values: [...widthsOf(bottom), ["eta", bottom.eta], ["k", bottom.k]],
        inner: null,
      };
    case "diffuse":
      return {
        type: "diffuse",
        strings: [],
        values: [["reflectance", bottom.reflectance]],
        inner: null,
      };
    case "dielectric":
      throw new Refusal("Mitsuba has no opaque dielectric; choose another bottom.");
    case "codes":
      throw new Refusal(
        "A loaded material is rendered from its own file, by the plugin neural_brdf.",
      );
  }
}

function xmlLines(node: Node, depth: number, id: string | null): string[] {
  const indent = "    ".repeat(depth);
  const named = id === null ? ' name="bottom"' : ` id="${id}"`;
  const lines = [`${indent}<bsdf type="${node.type}"${named}>`];
  for (const [name, value] of node.strings)
    lines.push(`${indent}    <string name="${name}" value="${value}"/>`);
  for (const name of node.switches ?? [])
    lines.push(`${indent}    <boolean name="${name}" value="true"/>`);
  for (const [name, value] of node.values) {
    const element = typeof value === "number" && !isColour(name) ? "float" : "rgb";
    lines.push(`${indent}    <${element} name="${name}" value="${listed(value)}"/>`);
  }
  if (node.inner !== null) lines.push(...xmlLines(node.inner, depth + 1, null));
  return [...lines, `${indent}</bsdf>`];
}

function dictLines(node: Node, depth: number): string[] {
  const indent = "    ".repeat(depth + 1);
  const lines = [`${"    ".repeat(depth)}{`, `${indent}"type": "${node.type}",`];
  for (const [name, value] of node.strings) lines.push(`${indent}"${name}": "${value}",`);
  for (const name of node.switches ?? []) lines.push(`${indent}"${name}": True,`);
  for (const [name, value] of node.values) {
    const plain = typeof value === "number" && !isColour(name);
    const text = plain ? value : `{"type": "rgb", "value": [${listed(value)}]}`;
    lines.push(`${indent}"${name}": ${text},`);
  }
  if (node.inner !== null) {
    const [first, ...rest] = dictLines(node.inner, depth + 1);
    lines.push(`${indent}"bottom": ${first!.trimStart()}`, ...rest);
    lines[lines.length - 1] += ",";
  }
  return [...lines, `${"    ".repeat(depth)}}`];
}

/** Parameters that Mitsuba reads as colours, whether one number or three. */
function isColour(name: string): boolean {
  return ["reflectance", "specular_reflectance", "k", "eta"].includes(name);
}

/** "0.1" or "0.1, 0.2, 0.3". */
function listed(value: Channels): string {
  return typeof value === "number" ? String(value) : value.join(", ");
}
