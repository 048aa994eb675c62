/** A texture of codes on the graphics card, and the program that decodes it. */

import { CHANNELS } from "../core/channels";
import { type FTable, NODES } from "../core/f_table";
import type { ShownTexture } from "../engine/opened";
import type { CodeTexture, Wrap } from "../material/texture";
import { TABLE } from "../printed/formulas";
import { Refusal } from "../refusal";
import { filters, type Gl, included, Program } from "./gl";
import frameSource from "./shaders/frame.glsl?raw";
import texelsSource from "./shaders/texels.frag?raw";

/** A texture of codes that a renderer can draw. */
export interface TexelProgram {
  program: Program;
  texture: WebGLTexture;
  basis: WebGLTexture;
}

/**
 * Compile and upload.
 *
 * @throws Refusal if the texture is too large for the graphics driver.
 */
export function texelProgram(gl: Gl, shown: ShownTexture): TexelProgram {
  const { texture: codes, shader, basis } = shown;
  const most = gl.getParameter(gl.MAX_TEXTURE_SIZE) as number;
  const [width, height] = codes.size;
  if (Math.max(width, height) > most)
    throw new Refusal(
      `The texture has ${width} by ${height} texels; the graphics driver takes ${most} a side.`,
    );
  const layers = Math.max(Math.ceil(codes.usedBytes / 4), 1);
  const source = included(texelsSource, { "frame.glsl": frameSource, "material.glsl": shader });
  const program = new Program(gl, source.replaceAll("LAYERS", String(layers)), {
    SPREAD: codes.nearest ? 0 : 1,
  });
  const texture = uploaded(gl, codes, layers);
  return { program, texture, basis: volume(gl, gl.createTexture()!, basis) };
}

/**
 * Put texels into a texture of three dimensions, whose two outer ones are the coordinates u and v of
 * tables; of half floats, where the graphics card filters no others.
 */
export function volume(gl: Gl, texture: WebGLTexture, texels: Float32Array): WebGLTexture {
  const [depth, height] = TABLE.SHAPE;
  const width = texels.length / (4 * depth * height);
  gl.activeTexture(gl.TEXTURE0);
  const target = gl.TEXTURE_3D;
  gl.bindTexture(target, texture);
  const linear = gl.getExtension("OES_texture_float_linear") !== null;
  const format = linear ? gl.RGBA32F : gl.RGBA16F;
  gl.texImage3D(target, 0, format, width, height, depth, 0, gl.RGBA, gl.FLOAT, texels);
  filters(gl, target, gl.LINEAR, gl.LINEAR, gl.CLAMP_TO_EDGE);
  return texture;
}

/** The texels of a table: along x, the coordinate w is repeated for blocks of terms. */
export function tableTexels({ logs }: FTable): Float32Array {
  const inner = TABLE.SHAPE[2];
  const terms = logs.length / (CHANNELS * NODES);
  const texels = new Float32Array(4 * NODES * terms);
  for (let at = 0; at < logs.length; at++) {
    const [row, term] = [Math.floor(at / terms), at % terms];
    const [node, channel] = [Math.floor(row / CHANNELS), row % CHANNELS];
    const texel = (Math.floor(node / inner) * terms + term) * inner + (node % inner);
    texels[4 * texel + channel] = logs[at];
  }
  return texels;
}

/** An array texture: four bytes of the texels a layer, as Python's `textures.gpu` has it. */
function uploaded(gl: Gl, codes: CodeTexture, layers: number): WebGLTexture {
  const { size, texels, texelBytes } = codes;
  const [width, height] = size;
  const target = gl.TEXTURE_2D_ARRAY;
  const texture = gl.createTexture()!;
  gl.activeTexture(gl.TEXTURE0);
  gl.bindTexture(target, texture);
  gl.texStorage3D(target, 1, gl.RGBA8, width, height, layers);
  gl.pixelStorei(gl.UNPACK_ALIGNMENT, 4);
  const four = new Uint8Array(4 * width * height);
  for (let layer = 0; layer < layers; layer++) {
    for (let texel = 0; texel < width * height; texel++) {
      const from = texel * texelBytes + 4 * layer;
      for (let byte = 0; byte < 4; byte++) four[4 * texel + byte] = texels[from + byte];
    }
    gl.texSubImage3D(target, 0, 0, 0, layer, width, height, 1, gl.RGBA, gl.UNSIGNED_BYTE, four);
  }
  filters(gl, target, gl.NEAREST, gl.NEAREST, wrapOf(gl, codes.wrap));
  return texture;
}

function wrapOf(gl: Gl, wrap: Wrap): number {
  if (wrap === "clamp") return gl.CLAMP_TO_EDGE;
  return wrap === "mirror" ? gl.MIRRORED_REPEAT : gl.REPEAT;
}
