/** What the picture is drawn into: a frame with smooth edges, and the mean of all frames. */

import { filters, type Gl } from "./gl";

export class Targets {
  width = 0;
  height = 0;
  /** The last frame. */
  frame!: WebGLTexture;
  /** The mean of the frames. */
  picture!: WebGLTexture;
  private readonly many: WebGLFramebuffer;
  private readonly single: WebGLFramebuffer;
  private readonly mean: WebGLFramebuffer;
  private readonly samples: number;
  /** Full floats where they blend, otherwise half floats. */
  private readonly format: number;
  private buffers: WebGLRenderbuffer[] = [];

  constructor(private readonly gl: Gl) {
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
    if (this.width > 0) {
      gl.deleteTexture(this.frame);
      gl.deleteTexture(this.picture);
    }
    this.width = width;
    this.height = height;
    const colour = this.buffer(gl.RGBA16F);
    const depth = this.buffer(gl.DEPTH_COMPONENT24);
    this.buffers = [colour, depth];
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.many);
    const target = gl.FRAMEBUFFER;
    gl.framebufferRenderbuffer(target, gl.COLOR_ATTACHMENT0, gl.RENDERBUFFER, colour);
    gl.framebufferRenderbuffer(target, gl.DEPTH_ATTACHMENT, gl.RENDERBUFFER, depth);
    this.frame = this.texture(gl.RGBA16F, this.single);
    this.picture = this.texture(this.format, this.mean);
    gl.bindFramebuffer(target, null);
  }

  /** Empty the frame. */
  clear(): void {
    const { gl } = this;
    this.bind();
    gl.disable(gl.SCISSOR_TEST);
    gl.clearColor(0, 0, 0, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
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

  /** Draw into the mean from here on. */
  bindMean(): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.mean);
    gl.viewport(0, 0, this.width, this.height);
  }

  private buffer(format: number): WebGLRenderbuffer {
    const { gl } = this;
    const buffer = gl.createRenderbuffer()!;
    gl.bindRenderbuffer(gl.RENDERBUFFER, buffer);
    const { RENDERBUFFER } = gl;
    gl.renderbufferStorageMultisample(RENDERBUFFER, this.samples, format, this.width, this.height);
    return buffer;
  }

  private texture(format: number, frame: WebGLFramebuffer): WebGLTexture {
    const { gl } = this;
    const texture = gl.createTexture()!;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    gl.texStorage2D(gl.TEXTURE_2D, 1, format, this.width, this.height);
    filters(gl, gl.TEXTURE_2D, gl.LINEAR, gl.LINEAR, gl.CLAMP_TO_EDGE);
    gl.bindFramebuffer(gl.FRAMEBUFFER, frame);
    const target = gl.TEXTURE_2D;
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, texture, 0);
    return texture;
  }
}
