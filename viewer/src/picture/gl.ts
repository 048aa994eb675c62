/** Small helpers on top of WebGL2. */

import { Refusal } from "../refusal";
import coverSource from "./shaders/cover.vert?raw";

export type Gl = WebGL2RenderingContext;

/** WebGL2 is missing, or lacks what the picture needs. */
export class NoGraphics extends Refusal {}

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

/** A number or a truth, a vector, a matrix column by column, or a texture. */
type Uniform = number | boolean | ArrayLike<number> | WebGLTexture;

/** Uniforms by their names in the shaders; a program ignores those that it does not read. */
export type Uniforms = Readonly<Record<string, Uniform>>;

/** A linked program; one without a vertex shader of its own runs over the whole viewport. */
export class Program {
  private readonly program: WebGLProgram;
  private readonly setters = new Map<string, (value: Uniform) => void>();

  constructor(
    private readonly gl: Gl,
    fragment: string,
    constants: Record<string, number> = {},
    vertex = coverSource,
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
    if (gl.isContextLost()) return;
    if (!gl.getProgramParameter(this.program, gl.LINK_STATUS)) {
      const logs = gl.getAttachedShaders(this.program)!.map((s) => gl.getShaderInfoLog(s));
      throw new NoGraphics(
        `The graphics driver refused a shader: ${logs.join(" ")}${gl.getProgramInfoLog(this.program)}`,
      );
    }
    this.findUniforms();
  }

  /** Give the program back. */
  delete(): void {
    this.gl.deleteProgram(this.program);
  }

  /** Draw by it from here on. */
  use(uniforms: Uniforms = {}): void {
    this.gl.useProgram(this.program);
    for (const [name, value] of Object.entries(uniforms)) this.setters.get(name)?.(value);
  }

  /** Draw over the whole viewport. */
  cover(uniforms: Uniforms = {}): void {
    this.use(uniforms);
    this.gl.drawArrays(this.gl.TRIANGLES, 0, 3);
  }

  /** Each sampler has a texture unit of its own. */
  private findUniforms(): void {
    const { gl, program } = this;
    const targets: Record<number, number> = {
      [gl.SAMPLER_2D]: gl.TEXTURE_2D,
      [gl.SAMPLER_3D]: gl.TEXTURE_3D,
      [gl.SAMPLER_CUBE]: gl.TEXTURE_CUBE_MAP,
      [gl.SAMPLER_2D_ARRAY]: gl.TEXTURE_2D_ARRAY,
    };
    const kinds = {
      [gl.FLOAT_VEC2]: (place, value) => gl.uniform2fv(place, value),
      [gl.FLOAT_VEC3]: (place, value) => gl.uniform3fv(place, value),
      [gl.FLOAT_VEC4]: (place, value) => gl.uniform4fv(place, value),
      [gl.FLOAT_MAT3x2]: (place, value) => gl.uniformMatrix3x2fv(place, false, value),
      [gl.FLOAT_MAT3]: (place, value) => gl.uniformMatrix3fv(place, false, value),
      [gl.FLOAT_MAT4]: (place, value) => gl.uniformMatrix4fv(place, false, value),
      [gl.FLOAT]: (place, value) => gl.uniform1f(place, Number(value)),
    } as Record<number, (place: WebGLUniformLocation | null, value: never) => void>;
    gl.useProgram(program);
    let units = 0;
    for (let k = gl.getProgramParameter(program, gl.ACTIVE_UNIFORMS) - 1; k >= 0; k--) {
      const { name, type } = gl.getActiveUniform(program, k)!;
      const place = gl.getUniformLocation(program, name);
      const [target, unit] = [targets[type], units];
      if (target) gl.uniform1i(place, units++);
      this.setters.set(name.replace("[0]", ""), (value) => {
        if (target) {
          gl.activeTexture(gl.TEXTURE0 + unit);
          gl.bindTexture(target, value as WebGLTexture);
        } else if (kinds[type]) kinds[type](place, value as never);
        else gl.uniform1i(place, Number(value));
      });
    }
  }
}

/** A source with texts in the place of its lines `#include NAME`. */
export function included(source: string, texts: Record<string, string>): string {
  return source.replace(/^#include (\S+)$/gm, (_line, name: string) => texts[name]);
}

/** Filters of the texture that is bound to `target`. */
export function filters(gl: Gl, target: number, small: number, large: number, wrap: number): void {
  gl.texParameteri(target, gl.TEXTURE_MIN_FILTER, small);
  gl.texParameteri(target, gl.TEXTURE_MAG_FILTER, large);
  gl.texParameteri(target, gl.TEXTURE_WRAP_S, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_T, wrap);
  gl.texParameteri(target, gl.TEXTURE_WRAP_R, wrap);
}

/** Textures of one size that are drawn into together. */
export class Target {
  /** One for each format; none with several samples. */
  readonly textures: WebGLTexture[] = [];
  readonly frame: WebGLFramebuffer;
  private readonly buffers: WebGLRenderbuffer[] = [];

  /** @param samples of a pixel, if they are several. */
  constructor(
    private readonly gl: Gl,
    readonly width: number,
    readonly height: number,
    formats: readonly number[],
    { filter = gl.LINEAR as number, samples = 0, hasDepth = false } = {},
  ) {
    this.frame = gl.createFramebuffer()!;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    const addBuffer = (format: number, attachment: number) => {
      const buffer = gl.createRenderbuffer()!;
      gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
      gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, attachment, gl.RENDERBUFFER, buffer);
      this.buffers.push(buffer);
    };
    const places = formats.map((_, k) => gl.COLOR_ATTACHMENT0 + k);
    for (const [k, format] of formats.entries()) {
      if (samples > 0) {
        addBuffer(format, places[k]);
        continue;
      }
      const texture = gl.createTexture()!;
      gl.bindTexture(gl.TEXTURE_2D, texture);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      filters(gl, gl.TEXTURE_2D, filter, filter, gl.CLAMP_TO_EDGE);
      gl.framebufferTexture2D(gl.FRAMEBUFFER, places[k], gl.TEXTURE_2D, texture, 0);
      this.textures.push(texture);
    }
    if (hasDepth) addBuffer(gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT);
    gl.drawBuffers(places);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  /** Draw into the whole of it from here on. */
  bind(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.frame);
    this.gl.viewport(0, 0, this.width, this.height);
  }

  /** The colours (height, width, 3) of its first texture or a left part, the lowest row first. */
  read(width = this.width): Float32Array {
    const { gl, height } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    const pixels = new Float32Array(4 * width * height);
    gl.readPixels(0, 0, width, height, gl.RGBA, gl.FLOAT, pixels);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    return pixels.filter((_, at) => at % 4 < 3);
  }

  delete(): void {
    const { gl } = this;
    gl.deleteFramebuffer(this.frame);
    for (const texture of this.textures) gl.deleteTexture(texture);
    for (const buffer of this.buffers) gl.deleteRenderbuffer(buffer);
  }
}
