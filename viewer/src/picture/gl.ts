/** Small helpers on top of WebGL2. */

import { type Light, MOST_LIGHTS } from "./panorama";
import coverSource from "./shaders/cover.vert?raw";

export type Gl = WebGL2RenderingContext;

/** WebGL2 is missing, or lacks what the picture needs. */
export class NoGraphics extends Error {}

/** The context of a canvas, with float targets. */
export function contextOf(canvas: HTMLCanvasElement): Gl {
  const gl = canvas.getContext("webgl2", {
    antialias: false,
    depth: false,
    preserveDrawingBuffer: true,
    powerPreference: "high-performance",
  });
  if (gl === null)
    throw new NoGraphics(
      "This browser offers no WebGL 2, which the picture needs; the cards and plots work without.",
    );
  if (!gl.getExtension("EXT_color_buffer_float"))
    throw new NoGraphics(
      "This graphics driver cannot draw into float textures, which the picture needs; the cards and plots work without.",
    );
  gl.getExtension("OES_texture_float_linear");
  gl.getExtension("EXT_float_blend");
  return gl;
}

/** A linked program with its uniforms by name. */
export class Program {
  private readonly program: WebGLProgram;
  private readonly places = new Map<string, WebGLUniformLocation | null>();

  constructor(
    private readonly gl: Gl,
    vertex: string,
    fragment: string,
    constants: Record<string, number> = {},
  ) {
    const defined = Object.entries(constants).map(
      ([name, value]) => `#define ${name} ${value.toFixed(6)}\n`,
    );
    this.program = gl.createProgram()!;
    for (const [kind, source] of [
      [gl.VERTEX_SHADER, vertex],
      [gl.FRAGMENT_SHADER, fragment.replace(/^(#version .*\n)/, `$1${defined.join("")}`)],
    ] as const) {
      const shader = gl.createShader(kind)!;
      gl.shaderSource(shader, source);
      gl.compileShader(shader);
      gl.attachShader(this.program, shader);
      gl.deleteShader(shader);
    }
    gl.linkProgram(this.program);
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS) && !gl.isContextLost()) {
      const logs = gl.getAttachedShaders(this.program)!.map((s) => gl.getShaderInfoLog(s));
      throw new NoGraphics(
        `The graphics driver refused a shader: ${logs.join(" ")}${gl.getProgramInfoLog(this.program)}`,
      );
    }
  }

  /** Give the program back. */
  delete(): void {
    this.gl.deleteProgram(this.program);
  }

  use(): void {
    this.gl.useProgram(this.program);
  }

  /** A number, or a vector of two, three or four. */
  set(name: string, ...value: number[]): void {
    const { gl } = this;
    const place = this.place(name);
    if (value.length === 1) gl.uniform1f(place, value[0]!);
    else if (value.length === 2) gl.uniform2f(place, value[0]!, value[1]!);
    else if (value.length === 3) gl.uniform3f(place, value[0]!, value[1]!, value[2]!);
    else gl.uniform4f(place, value[0]!, value[1]!, value[2]!, value[3]!);
  }

  setInteger(name: string, value: number): void {
    this.gl.uniform1i(this.place(name), value);
  }

  setVectors(name: string, values: Float32Array): void {
    this.gl.uniform3fv(this.place(name), values);
  }

  setLights(lights: readonly Light[]): void {
    const of = (key: keyof Light) => {
      const values = new Float32Array(3 * MOST_LIGHTS);
      lights.forEach((light, place) => {
        values.set(light[key], 3 * place);
      });
      return values;
    };
    this.setInteger("lights", lights.length);
    this.setVectors("lightDirections", of("direction"));
    this.setVectors("lightPowers", of("power"));
  }

  /** A matrix, column by column: of two rows and three columns, or of three or four of both. */
  setMatrix(name: string, values: readonly number[]): void {
    if (values.length === 6) this.gl.uniformMatrix3x2fv(this.place(name), false, values);
    else if (values.length === 9) this.gl.uniformMatrix3fv(this.place(name), false, values);
    else this.gl.uniformMatrix4fv(this.place(name), false, values);
  }

  /** Bind a texture to a unit for a sampler. */
  setTexture(name: string, unit: number, target: number, texture: WebGLTexture): void {
    this.gl.activeTexture(this.gl.TEXTURE0 + unit);
    this.gl.bindTexture(target, texture);
    this.setInteger(name, unit);
  }

  private place(name: string): WebGLUniformLocation | null {
    if (!this.places.has(name))
      this.places.set(name, this.gl.getUniformLocation(this.program, name));
    return this.places.get(name)!;
  }
}

/** A source with texts in the place of its lines `#include NAME`. */
export function included(source: string, texts: Record<string, string>): string {
  return source.replace(/^#include (\S+)$/gm, (_line, name: string) => texts[name]!);
}

/** A program that runs over the whole viewport; draw it by `cover`. */
export function coverProgram(
  gl: Gl,
  fragment: string,
  constants: Record<string, number> = {},
): Program {
  return new Program(gl, coverSource, fragment, constants);
}

export function cover(gl: Gl): void {
  gl.drawArrays(gl.TRIANGLES, 0, 3);
}

/** Filters of the texture that is bound to `target`. */
export function filters(gl: Gl, target: number, small: number, large: number, wrap: number): void {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, small);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, large);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_R, wrap);
}

/** The colours (height, width, 3) of the framebuffer that is bound, the lowest row first. */
export function readRgb(gl: Gl, width: number, height: number): Float32Array {
  const pixels = new Float32Array(4 * width * height);
  gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
  const rgb = new Float32Array(3 * width * height);
  for (let at = 0; at < width * height; at++) rgb.set(pixels.subarray(4 * at, 4 * at + 3), 3 * at);
  return rgb;
}
