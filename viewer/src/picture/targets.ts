/** What the picture is drawn into: a frame with smooth edges, and the mean of all frames. */

import type { Radiance } from "../save/exr";
import { filters, type Gl, readRgb } from "./gl";

export class Targets {
  width = 0;
  height = 0;
  /** Positions and normals of the surface that each pixel of the frame shows, and its colours. */
  positions!: WebGLTexture;
  normals!: WebGLTexture;
  /** Bent normals and openness of that surface. */
  openings!: WebGLTexture;
  /** Where each pixel lies in a texture of codes, and at which level. */
  places!: WebGLTexture;
  shaded!: WebGLTexture;
  /** The last frame. */
  frame!: WebGLTexture;
  /** The mean of the frames. */
  picture!: WebGLTexture;
  private readonly surface: WebGLFramebuffer;
  private readonly shading: WebGLFramebuffer;
  private readonly many: WebGLFramebuffer;
  private readonly single: WebGLFramebuffer;
  private readonly mean: WebGLFramebuffer;
  private readonly samples: number;
  /** Full floats where they blend, otherwise half floats. */
  private readonly format: number;
  private buffers: WebGLRenderbuffer[] = [];

  constructor(private readonly gl: Gl) {
    this.surface = gl.createFramebuffer()!;
    this.shading = gl.createFramebuffer()!;
    this.many = gl.createFramebuffer()!;
    this.single = gl.createFramebuffer()!;
    this.mean = gl.createFramebuffer()!;
    const counts = gl.getInternalformatParameter(gl.RENDERBUFFER, gl.RGBA16F, gl.SAMPLES);
    const most = Math.max(0, ...((counts as Int32Array | null) ?? []));
    this.samples = Math.min(4, most);
    const full = gl.getExtension("EXT_float_blend") && gl.getExtension("OES_texture_float_linear");
    this.format = full ? gl.RGBA32F : gl.RGBA16F;
  }

  /** Take another size [pixels]; what was gathered is lost. */
  resize(width: number, height: number): void {
    if (width === this.width && height === this.height) return;
    const { gl } = this;
    for (const buffer of this.buffers) gl.deleteRenderbuffer(buffer);
    if (this.width > 0)
      for (const texture of [
        this.positions,
        this.normals,
        this.openings,
        this.places,
        this.shaded,
        this.frame,
        this.picture,
      ])
        gl.deleteTexture(texture);
    this.width = width;
    this.height = height;
    const colour = this.buffer(gl.RGBA16F, this.samples);
    const depth = this.buffer(gl.DEPTH_COMPONENT24, this.samples);
    const single = this.buffer(gl.DEPTH_COMPONENT24, 0);
    this.buffers = [colour, depth, single];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.many);
    const target = gl.FRAMEBUFFER;
    gl.framebufferRenderbuffer(target, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
    gl.framebufferRenderbuffer(target, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    this.frame = this.texture(gl.RGBA16F, this.single);
    this.picture = this.texture(this.format, this.mean);
    this.shaded = this.texture(gl.RGBA16F, this.shading);
    this.positions = this.texture(gl.RGBA32F, this.surface);
    this.normals = this.texture(gl.RGBA32F, this.surface, gl.COLOR_ATTACHMENT1);
    this.places = this.texture(gl.RGBA32F, this.surface, gl.COLOR_ATTACHMENT2);
    this.openings = this.texture(gl.RGBA16F, this.surface, gl.COLOR_ATTACHMENT3);
    gl.framebufferRenderbuffer(target, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, single);
    gl.drawBuffers([0, 1, 2, 3].map((place) => gl.COLOR_ATTACHMENT0 + place));
    gl.bindFramebuffer(target, null);
  }

  /** Empty the frame. */
  clear(): void {
    const { gl } = this;
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 0);
    for (const buffer of [this.surface, this.shading, this.many]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    }
  }

  /** Forget the surface in the scissored part, which the next mesh covers. */
  clearSurface(): void {
    const { gl } = this;
    for (const buffer of [this.surface, this.shading]) {
      gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
      gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    }
  }

  /** Draw positions and normals from here on. */
  bindSurface(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.surface);
  }

  /** Draw the surface's colours from here on. */
  bindShaded(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.shading);
  }

  /** Draw into the frame from here on. */
  bind(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.many);
  }

  /** Average the frame's samples in each pixel. */
  resolve(): void {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, this.many);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, this.single);
    gl.blitFramebuffer(0, 0, width, height, 0, 0, width, height, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  /** Draw into the averaged frame from here on, once it has been gathered. */
  bindFrame(): void {
    this.gl.bindFramebuffer(this.gl.FRAMEBUFFER, this.single);
  }

  /** Draw into the mean from here on. */
  bindMean(): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.mean);
    gl.viewport(0, 0, this.width, this.height);
  }

  /** The mean of the frames, the first row at the top. */
  read(): Radiance {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.mean);
    const upward = readRgb(gl, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const pixels = new Float32Array(upward.length);
    for (let y = 0; y < height; y++)
      pixels.set(upward.subarray(3 * width * y, 3 * width * (y + 1)), 3 * width * (height - 1 - y));
    return { width, height, pixels };
  }

  private buffer(format: number, samples: number): WebGLRenderbuffer {
    const { gl } = this;
    const buffer = gl.createRenderbuffer()!;
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    const { RENDERBUFFER } = gl;
    gl.renderbufferStorageMultisample(RENDERBUFFER, samples, format, this.width, this.height);
    return buffer;
  }

  private texture(
    format: number,
    frame: WebGLFramebuffer,
    attachment: number = this.gl.COLOR_ATTACHMENT0,
  ): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture()!;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, this.width, this.height);
    const filter = frame === this.mean ? gl.LINEAR : gl.NEAREST;
    filters(gl, gl.TEXTURE_2D, filter, filter, gl.CLAMP_TO_EDGE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, attachment, gl.TEXTURE_2D, texture, 0);
    return texture;
  }
}
