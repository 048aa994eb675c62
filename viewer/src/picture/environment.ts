/** Environments as cube maps with filtered levels, and the bright lights taken out of them. */

import type { EnvironmentName } from "../state/state";
import { filters, type Gl, Program, Target } from "./gl";
import type { Light, Picture } from "./panorama";
import halveSource from "./shaders/halve.frag?raw";
import irradianceSource from "./shaders/irradiance.frag?raw";
import panoramaSource from "./shaders/panorama.frag?raw";
import placesSource from "./shaders/places.frag?raw";
import { unit } from "./vectors";

/** Texels along a side of a face. */
export const SIDE = 256;
const LEVELS = Math.log2(SIDE) + 1;

/** Texels along a side of a face of the irradiance, and the level of the light that it is made of. */
const IRRADIANCE_SIDE = 16;
const IRRADIANCE_LEVEL = Math.log2(SIDE / IRRADIANCE_SIDE);

/** From (x, y, 1) on a face to a direction, column by column, in WebGL's order of the faces. */
const FACES = [
  [0, 0, -1, 0, -1, 0, 1, 0, 0],
  [0, 0, 1, 0, -1, 0, -1, 0, 0],
  [1, 0, 0, 0, 0, 1, 0, 1, 0],
  [1, 0, 0, 0, 0, -1, 0, -1, 0],
  [1, 0, 0, 0, -1, 0, 0, 0, 1],
  [-1, 0, 0, 0, -1, 0, 0, 0, -1],
] as const;

const FORMULAS: readonly EnvironmentName[] = ["studio", "sky", "room"];

/** The sky's sun stands where its shader's does. */
const SUN: Light = { direction: unit([-0.5, -0.62, 0.6]), power: [3.4, 3.05, 2.55] };

/** The lights of an environment by formula. */
export function lightsOf(name: EnvironmentName): Light[] {
  return name === "sky" ? [SUN] : [];
}

/** The formula of an environment; that of the studio while its panorama is missing. */
const formulaOf = (name: EnvironmentName) => Math.max(FORMULAS.indexOf(name), 0);

/** Draws environments into a cube map. */
export class EnvironmentMap {
  readonly texture: WebGLTexture;
  /** Irradiance over pi by the normal: the light of a white diffuse reflector. */
  readonly irradiance: WebGLTexture;
  private readonly convolve: Program;
  private readonly frame: WebGLFramebuffer;
  private readonly halve: Program;
  private readonly places: Program;
  private readonly panorama: Program;

  /** @param simple whether to filter within one level only, which is cheaper. */
  constructor(
    private readonly gl: Gl,
    simple: boolean,
  ) {
    const small = simple ? gl.LINEAR_MIPMAP_NEAREST : gl.LINEAR_MIPMAP_LINEAR;
    this.texture = cubeMap(gl, LEVELS, SIDE, small);
    this.irradiance = cubeMap(gl, 1, IRRADIANCE_SIDE, gl.LINEAR);
    this.convolve = new Program(gl, irradianceSource);
    this.frame = gl.createFramebuffer()!;
    this.halve = new Program(gl, halveSource);
    this.places = new Program(gl, placesSource);
    this.panorama = new Program(gl, panoramaSource);
  }

  /** Draw an environment by formula. */
  drawFormula(name: EnvironmentName): void {
    this.places.use({ which: formulaOf(name), isPanorama: false });
    this.drawFaces(this.places, this.texture, SIDE, 0);
    this.drawLevels();
  }

  /** An environment by formula as a panorama, without its bright lights. */
  panoramaOf(name: EnvironmentName): Picture {
    const { gl } = this;
    const target = new Target(gl, 4 * SIDE, 2 * SIDE, [gl.RGBA32F]);
    target.bind();
    this.places.cover({ which: formulaOf(name), isPanorama: true });
    const pixels = target.read();
    target.delete();
    return { width: target.width, height: target.height, pixels };
  }

  /** Draw a panorama. */
  drawPanorama(panorama: Picture): void {
    const { gl } = this;
    const texture = gl.createTexture()!;
    gl.bindTexture(gl.TEXTURE_2D, texture);
    const { width, height, pixels } = panorama;
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGB16F, width, height, 0, gl.RGB, gl.FLOAT, pixels);
    filters(gl, gl.TEXTURE_2D, gl.LINEAR, gl.LINEAR, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.REPEAT);
    this.panorama.use({ panorama: texture });
    this.drawFaces(this.panorama, this.texture, SIDE, 0);
    this.drawLevels();
    gl.deleteTexture(texture);
  }

  private drawLevels(): void {
    const { gl, halve, convolve, texture } = this;
    for (let level = 1; level < LEVELS; level++) {
      halve.use({ environment: texture, side: SIDE >> (level - 1) });
      // Only the finer levels are read while this one is drawn.
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_BASE_LEVEL, level - 1);
      gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAX_LEVEL, level - 1);
      this.drawFaces(halve, texture, SIDE >> level, level);
    }
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_BASE_LEVEL, 0);
    gl.texParameteri(gl.TEXTURE_CUBE_MAP, gl.TEXTURE_MAX_LEVEL, LEVELS - 1);
    convolve.use({ environment: texture, level: IRRADIANCE_LEVEL, side: IRRADIANCE_SIDE });
    this.drawFaces(convolve, this.irradiance, IRRADIANCE_SIDE, 0);
  }

  private drawFaces(program: Program, texture: WebGLTexture, side: number, level: number): void {
    const { gl } = this;
    gl.bindFramebuffer(gl.FRAMEBUFFER, this.frame);
    gl.viewport(0, 0, side, side);
    FACES.forEach((face, place) => {
      const target = gl.TEXTURE_CUBE_MAP_POSITIVE_X + place;
      gl.framebufferTexture2D(gl.FRAMEBUFFER, gl.COLOR_ATTACHMENT0, target, texture, level);
      program.cover({ face });
    });
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
  }
}

function cubeMap(gl: Gl, levels: number, side: number, small: number): WebGLTexture {
  const texture = gl.createTexture()!;
  gl.bindTexture(gl.TEXTURE_CUBE_MAP, texture);
  gl.texStorage2D(gl.TEXTURE_CUBE_MAP, levels, gl.RGBA16F, side, side);
  filters(gl, gl.TEXTURE_CUBE_MAP, small, gl.LINEAR, gl.CLAMP_TO_EDGE);
  return texture;
}
