/** The shadow of the object on the ground: how much of its light each place has. */

import { axesOf, GROUND_SIDE, MOST_AXES } from "../core/occlusion";
import type { EnvironmentMap } from "./environment";
import { cover, coverProgram, filters, type Gl, type Program } from "./gl";
import type { Light } from "./panorama";
import groundSource from "./shaders/ground.frag?raw";
import hemisphereSource from "./shaders/hemisphere.frag?raw";
import softenSource from "./shaders/soften.frag?raw";

export class Ground {
  /** Share of the light, in each channel, in the square of `GROUND_SIZE`. */
  readonly texture: WebGLTexture;
  private readonly program: Program;
  private readonly hemisphere: Program;
  private readonly soften: Program;
  private readonly lit: WebGLTexture;
  private readonly sharp: WebGLTexture;
  private readonly frame: WebGLFramebuffer;
  private readonly shadows: WebGLTexture;
  private axes = 0;
  /** What the texture is of. */
  private key = "";

  constructor(private readonly gl: Gl) {
    this.program = coverProgram(gl, groundSource);
    this.frame = gl.createFramebuffer()!;
    this.shadows = gl.createTexture()!;
    this.hemisphere = coverProgram(gl, hemisphereSource);
    this.soften = coverProgram(gl, softenSource);
    const texture = (width = GROUND_SIDE, height = GROUND_SIDE) => {
      const made = gl.createTexture()!;
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.texStorage2D(gl.TEXTURE_2D, 1, gl.RGBA16F, width, height);
      filters(gl, gl.TEXTURE_2D, gl.LINEAR, gl.LINEAR, gl.CLAMP_TO_EDGE);
      return made;
    };
    this.lit = texture(MOST_AXES, 1);
    this.sharp = texture();
    this.texture = texture();
    this.setShadows(new Uint8Array(0));
  }

  /** Take over the shadows of `Occlusion`; none: the object casts none yet. */
  setShadows(shadows: Uint8Array): void {
    const { gl } = this;
    this.axes = axesOf(shadows);
    this.key = "";
    const target = gl.TEXTURE_2D_ARRAY;
    const [side, layers] = this.axes > 0 ? [GROUND_SIDE, this.axes] : [1, 1];
    const texels = this.axes > 0 ? shadows : new Uint8Array(1);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(target, this.shadows);
    gl.pixelStorei(gl.UNPACK_ALIGNMENT, 1);
    gl.texImage3D(target, 0, gl.R8, side, side, layers, 0, gl.RED, gl.UNSIGNED_BYTE, texels);
    filters(gl, target, gl.NEAREST, gl.NEAREST, gl.CLAMP_TO_EDGE);
  }

  /** Another environment lies in the map. */
  changed(): void {
    this.key = "";
  }

  /**
   * Let the light be that of an environment and its bright lights.
   *
   * @param turn cosine and sine of the environment's rotation.
   * @param contact radius of the object relative to half the square's side.
   */
  light(
    map: EnvironmentMap,
    lights: readonly Light[],
    turn: readonly [number, number],
    contact: number,
  ): void {
    const key = String(turn);
    if (key === this.key) return;
    this.key = key;
    const { gl, program, soften, hemisphere } = this;
    gl.disable(gl.DEPTH_TEST);
    gl.disable(gl.SCISSOR_TEST);
    hemisphere.use();
    hemisphere.setTexture("environment", 0, gl.TEXTURE_CUBE_MAP, map.texture);
    hemisphere.setInteger("axes", this.axes);
    hemisphere.set("turn", ...turn);
    hemisphere.setLights(lights);
    this.into(this.lit, MOST_AXES, 1);
    program.use();
    program.setTexture("lit", 0, gl.TEXTURE_2D, this.lit);
    program.setTexture("shadows", 1, gl.TEXTURE_2D_ARRAY, this.shadows);
    program.setInteger("axes", this.axes);
    this.into(this.sharp);
    soften.use();
    soften.setTexture("sharp", 0, gl.TEXTURE_2D, this.sharp);
    soften.set("contact", contact);
    this.into(this.texture);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }

  private into(texture: WebGLTexture, width = GROUND_SIDE, height = GROUND_SIDE): void {
    const { gl } = this;
    gl.viewport(0, 0, width, height);
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    const target = gl.TEXTURE_2D;
    gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, texture, 0);
    cover(gl);
  }
}
