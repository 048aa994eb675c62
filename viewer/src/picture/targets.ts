/** What the picture is drawn into: coarse shading, a frame with smooth edges, and the mean of all frames. */

import { filters, type Gl, readRgb } from "./gl";
import type { Picture } from "./panorama";

export class Targets {
  width = 0;
  height = 0;
  /** Width of the shading relative to the frame's. */
  scale = 0;
  /** Positions and normals of the surface that each pixel of the shading shows, and its colours. */
  positions!: WebGLTexture;
  normals!: WebGLTexture;
  /** Bent normals and openness of that surface. */
  openings!: WebGLTexture;
  /** Where each pixel lies in a texture of codes, and at which level. */
  places!: WebGLTexture;
  shaded!: WebGLTexture;
  /** The object as the ground reflects it. */
  mirror!: WebGLTexture;
  /** The last frame. */
  frame!: WebGLTexture;
  /** The mean of the frames. */
  picture!: WebGLTexture;
  private readonly surface: WebGLFramebuffer;
  private readonly shading: WebGLFramebuffer;
  private readonly mirroring: WebGLFramebuffer;
  private readonly many: WebGLFramebuffer;
  private readonly single: WebGLFramebuffer;
  private readonly mean: WebGLFramebuffer;
  private readonly samples: number;
  /** Full floats where they blend, otherwise half floats. */
  private readonly format: number;
  private buffers: WebGLRenderbuffer[] = [];
  private coarse: WebGLRenderbuffer | null = null;

  constructor(private readonly gl: Gl) {
    const frame = () => gl.createFramebuffer()!;
    this.surface = frame();
    this.shading = frame();
    this.mirroring = frame();
    this.many = frame();
    this.single = frame();
    this.mean = frame();
    const counts = gl.getInternalformatParameter(gl.RENDERBUFFER, gl.RGBA16F, gl.SAMPLES);
    const most = Math.max(0, ...((counts as Int32Array | null) ?? []));
    this.samples = Math.min(4, most);
    const full = gl.getExtension("EXT_float_blend") && gl.getExtension("OES_texture_float_linear");
    this.format = full ? gl.RGBA32F : gl.RGBA16F;
  }

  /** Take another size [pixels], by which what was gathered is lost, and another scale of the shading. */
  resize(width: number, height: number, scale: number): void {
    const { gl } = this;
    const isSame = width === this.width && height === this.height;
    if (isSame && scale === this.scale) return;
    this.scale = scale;
    if (!isSame) {
      [this.width, this.height] = [width, height];
      for (const buffer of this.buffers) gl.deleteRenderbuffer(buffer);
      for (const texture of [this.frame, this.picture]) gl.deleteTexture(texture ?? null);
      const colour = this.buffer(gl.RGBA16F, this.samples, width, height);
      const depth = this.buffer(gl.DEPTH_COMPONENT24, this.samples, width, height);
      this.buffers = [colour, depth];
      gl.bindFramebuffer(gl.FRAMEBUFFER, this.many);
      const target = gl.FRAMEBUFFER;
      gl.framebufferRenderbuffer(target, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
      gl.framebufferRenderbuffer(target, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
      this.frame = this.texture(gl.RGBA16F, this.single, width, height);
      this.picture = this.texture(this.format, this.mean, width, height, gl.LINEAR);
    }
    this.resizeShading(Math.ceil(width * scale), Math.ceil(height * scale));
  }

  private resizeShading(width: number, height: number): void {
    const { gl } = this;
    const { positions, normals, openings, places, shaded, mirror } = this;
    for (const texture of [positions, normals, openings, places, shaded, mirror])
      gl.deleteTexture(texture ?? null);
    gl.deleteRenderbuffer(this.coarse);
    this.coarse = this.buffer(gl.DEPTH_COMPONENT24, 0, width, height);
    this.mirror = this.texture(gl.RGBA16F, this.mirroring, width, height, gl.LINEAR);
    this.shaded = this.texture(gl.RGBA16F, this.shading, width, height);
    const of = (format: number, place: number) =>
      this.texture(format, this.surface, width, height, gl.NEAREST, gl.COLOR_ATTACHMENT0 + place);
    this.positions = of(gl.RGBA32F, 0);
    this.normals = of(gl.RGBA32F, 1);
    this.places = of(gl.RGBA32F, 2);
    this.openings = of(gl.RGBA16F, 3);
    const target = gl.FRAMEBUFFER;
    gl.framebufferRenderbuffer(target, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, this.coarse);
    gl.drawBuffers([0, 1, 2, 3].map((place) => gl.COLOR_ATTACHMENT0 + place));
    gl.bindFramebuffer(target, null);
  }

  /** Draw positions and normals from here on, in the scissored part, which is emptied. */
  bindSurface(): void {
    this.emptied(this.surface);
  }

  /** Draw the surface's colours from here on, or those of its mirror image. */
  bindShaded(isMirrored: boolean): void {
    this.emptied(isMirrored ? this.mirroring : this.shading);
  }

  /** Draw into the scissored part of the frame from here on, which is emptied. */
  bind(): void {
    this.emptied(this.many);
  }

  private emptied(buffer: WebGLFramebuffer): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, buffer);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
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
  read(): Picture {
    const { gl, width, height } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.mean);
    const upward = readRgb(gl, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    const pixels = new Float32Array(upward.length);
    for (let y = 0; y < height; y++)
      pixels.set(upward.subarray(3 * width * y, 3 * width * (y + 1)), 3 * width * (height - 1 - y));
    return { width, height, pixels };
  }

  private buffer(format: number, samples: number, width: number, height: number) {
    const { gl } = this;
    const buffer = gl.createRenderbuffer()!;
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    gl.renderbufferStorageMultisample(gl.RENDERBUFFER, samples, format, width, height);
    return buffer;
  }

  private texture(
    format: number,
    frame: WebGLFramebuffer,
    width: number,
    height: number,
    filter: number = this.gl.NEAREST,
    attachment: number = this.gl.COLOR_ATTACHMENT0,
  ): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture()!;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
    filters(gl, gl.TEXTURE_2D, filter, filter, gl.CLAMP_TO_EDGE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    gl.framebufferTexture2D(gl.FRAMEBUFFER, attachment, gl.TEXTURE_2D, texture, 0);
    return texture;
  }
}
