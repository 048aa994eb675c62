/** The shadow of the object on the ground: how much of its light each place has. */

import { axesOf, GROUND_SIDE, MOST_AXES } from "../core/occlusion";
import type { EnvironmentMap } from "./environment";
import { filters, type Gl, Program, Target, type Uniforms } from "./gl";
import { type Light, uniformsOf } from "./panorama";
import groundSource from "./shaders/ground.frag?raw";
import hemisphereSource from "./shaders/hemisphere.frag?raw";
import softenSource from "./shaders/soften.frag?raw";

export class Ground {
  private readonly program: Program;
  private readonly hemisphere: Program;
  private readonly soften: Program;
  private readonly lit: Target;
  private readonly sharp: Target;
  private readonly smooth: Target;
  private readonly shadows: WebGLTexture;
  private axes = 0;
  /** What the light is of. */
  private key = "";

  constructor(private readonly gl: Gl) {
    this.program = new Program(gl, groundSource);
    this.hemisphere = new Program(gl, hemisphereSource);
    this.soften = new Program(gl, softenSource);
    this.shadows = gl.createTexture()!;
    this.lit = new Target(gl, MOST_AXES, 1, [gl.RGBA16F]);
    this.sharp = new Target(gl, GROUND_SIDE, GROUND_SIDE, [gl.RGBA16F]);
    this.smooth = new Target(gl, GROUND_SIDE, GROUND_SIDE, [gl.RGBA16F]);
    this.setShadows(new Uint8Array(0));
  }

  /** Share of the light, in each channel, in the square of `groundSize`. */
  get texture(): WebGLTexture {
    return this.smooth.textures[0];
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
    const { axes, shadows } = this;
    const draw = (target: Target, program: Program, uniforms: Uniforms) => {
      target.bind();
      program.cover(uniforms);
      return target.textures[0];
    };
    const light = { environment: map.texture, axes, turn, ...uniformsOf(lights) };
    const lit = draw(this.lit, this.hemisphere, light);
    const sharp = draw(this.sharp, this.program, { lit, shadows, axes });
    draw(this.smooth, this.soften, { sharp, contact });
  }
}
