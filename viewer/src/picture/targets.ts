/** What the picture is drawn into: coarse shading, a frame with smooth edges, and the mean of all frames. */

import { type Gl, Target } from "./gl";
import type { Picture } from "./panorama";

export class Targets {
  /** The frame that is drawn, with several samples a pixel. */
  many!: Target;
  /** The last frame, its samples averaged. */
  frame!: Target;
  /** The mean of the frames. */
  mean!: Target;
  /** The surface that each pixel of the shading shows; see surface.frag. */
  surface!: Target;
  /** Its colours, and the object as the ground reflects it. */
  shaded!: Target;
  mirror!: Target;
  private size = "";
  private shading = "";

  constructor(private readonly gl: Gl) {}

  /**
   * Take another size [pixels], by which what was gathered is lost, and another scale of the shading,
   * its width relative to the frame's.
   */
  resize(width: number, height: number, scale: number): void {
    const { gl } = this;
    const { RGBA16F, RGBA32F, NEAREST } = gl;
    const size = `${width} ${height}`;
    if (size !== this.size) {
      this.size = size;
      for (const old of [this.many, this.frame, this.mean]) old?.delete();
      const counts = gl.getInternalformatParameter(gl.RENDERBUFFER, RGBA16F, gl.SAMPLES);
      const samples = Math.min(4, Math.max(0, ...((counts as Int32Array | null) ?? [])));
      this.many = new Target(gl, width, height, [RGBA16F], { samples, hasDepth: true });
      this.frame = new Target(gl, width, height, [RGBA16F], { filter: NEAREST });
      // Full floats where they blend, otherwise half floats
      const isFull =
        gl.getExtension("EXT_float_blend") && gl.getExtension("OES_texture_float_linear");
      this.mean = new Target(gl, width, height, [isFull ? RGBA32F : RGBA16F]);
    }
    const shading = `${size} ${scale}`;
    if (shading === this.shading) return;
    this.shading = shading;
    for (const old of [this.surface, this.shaded, this.mirror]) old?.delete();
    const [wide, tall] = [Math.ceil(width * scale), Math.ceil(height * scale)];
    const formats = [RGBA32F, RGBA32F, RGBA32F, RGBA16F];
    this.surface = new Target(gl, wide, tall, formats, { filter: NEAREST, hasDepth: true });
    this.shaded = new Target(gl, wide, tall, [RGBA16F], { filter: NEAREST });
    this.mirror = new Target(gl, wide, tall, [RGBA16F]);
  }

  /** The surface as the shaders read it. */
  get uniforms() {
    const [positions, normals, places, openings] = this.surface.textures;
    return { positions: positions!, normals: normals!, places: places!, openings: openings! };
  }

  /** Average the frame's samples in each pixel. */
  resolve(): void {
    const { gl, many, frame } = this;
    const box = [0, 0, frame.width, frame.height] as const;
    gl.bindFramebuffer(gl.READ_FRAMEBUFFER, many.frame);
    gl.bindFramebuffer(gl.DRAW_FRAMEBUFFER, frame.frame);
    gl.blitFramebuffer(...box, ...box, gl.COLOR_BUFFER_BIT, gl.NEAREST);
  }

  /** The mean of the frames as linear radiance, before exposure and tone curve. */
  read(): Picture {
    const { width, height } = this.mean;
    const upward = this.mean.read();
    const pixels = new Float32Array(upward.length);
    for (let y = 0; y < height; y++)
      pixels.set(upward.subarray(3 * width * y, 3 * width * (y + 1)), 3 * width * (height - 1 - y));
    return { width, height, pixels };
  }
}
