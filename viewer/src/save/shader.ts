/** Shader code of a material: Python's text for any material, with the codes of this one. */

import type { Material } from "../core/api";
import { CHANNELS } from "../core/channels";
import type { Widths } from "../core/f_table";
import { readFile } from "../engine/files";
import { COLOURS } from "../material/channels";
import type { CodeTexture, LinearNumber } from "../material/texture";
import { Refusal } from "../refusal";

/** Languages of shader code, by the names of Python's `export`: title and suffix of its files. */
export const LANGUAGES = {
  glsl: { title: "GLSL", suffix: ".glsl" },
  wgsl: { title: "WGSL", suffix: ".wgsl" },
  hlsl: { title: "HLSL", suffix: ".hlsl" },
  slang: { title: "Slang", suffix: ".slang" },
  osl: { title: "OSL", suffix: ".osl" },
  python: { title: "NumPy", suffix: "-numpy.py" },
} as const;

export type Language = keyof typeof LANGUAGES;

/**
 * The template of a language, which lies beside the page.
 *
 * @throws Refusal if it is missing.
 */
export async function readTemplate(language: Language, widths: Widths = 1): Promise<string> {
  const path = `shaders/${widths === 1 ? "" : "anisotropic/"}${language}.txt`;
  const bytes = await readFile(path);
  if (bytes === null) throw new Refusal(`The shader code is missing beside the page (${path}).`);
  return new TextDecoder().decode(bytes);
}

/**
 * A template with a material's codes in the place of `code_0_red` and so on.
 *
 * @param rotation of the material's tangent [degrees].
 */
export function shaderText(
  template: string,
  { latents }: Pick<Material, "latents">,
  rotation = 0,
): string {
  const size = latents.length / CHANNELS;
  const angle = (rotation * Math.PI) / 180;
  return filled(template, (number, channel) => shaderNumber(latents[channel * size + number]))
    .replace(/\bcode_tangent_x\b/, shaderNumber(Math.fround(Math.cos(angle))))
    .replace(/\bcode_tangent_y\b/, shaderNumber(Math.fround(Math.sin(angle))));
}

/**
 * A template in GLSL for a texture: its codes are those of a texel.
 *
 * A global array `stored` must hold the texel's bytes, each in [0, 1], before the template's
 * function `material` is called.
 */
export function texelShaderText(template: string, { numbers }: CodeTexture): string {
  return filled(template, (number, channel) => linear(numbers[number][channel]));
}

/** A template with texts in the place of its codes. */
function filled(template: string, text: (number: number, channel: number) => string): string {
  return template.replace(/\bcode_(\d+)_(red|green|blue)\b/g, (_name, number, colour) =>
    text(Number(number), COLOURS.indexOf(colour)),
  );
}

/** As the numbers of `texels` in Python's `textures.gpu`. */
function linear({ lowest, step, high, low }: LinearNumber): string {
  const term = (place: number, factor: number) => ` + stored[${place}] * ${shaderNumber(factor)}`;
  const offset = shaderNumber(lowest);
  if (high < 0) return offset;
  if (low < 0) return offset + term(high, 255 * step);
  return offset + term(high, 255 * 256 * step) + term(low, 255 * step);
}

/** The shortest text that reads back as the same number of single precision, with a point. */
export function shaderNumber(value: number): string {
  for (let digits = 1; digits < 9; digits++) {
    const short = Number(value.toPrecision(digits));
    if (Math.fround(short) === Math.fround(value)) return withPoint(short);
  }
  return withPoint(Number(value.toPrecision(9)));
}

function withPoint(value: number): string {
  const text = String(value);
  return /^-?\d+$/.test(text) ? `${text}.0` : text;
}
