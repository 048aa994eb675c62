/** A material on the graphics card: its table of directions, or a texture of codes in its place. */

import type { DirectionSizes, Material } from "../core/api";
import { CHANNELS, rows } from "../core/channels";
import { NODES } from "../core/f_table";
import { sequencePoint } from "../core/sequence";
import type { ShownTexture } from "../engine/opened";
import { LOBE } from "../printed/formulas";
import { directionTexels } from "./direction_table";
import { filters, type Gl, type Uniforms } from "./gl";
import { type TexelProgram, tableTexels, texelProgram, volume } from "./texel_program";

/** Directions of a frame where a texture of codes is decoded at each pixel. */
const TEXEL_SAMPLES = 32;

/** Numbers of the lobes of the channels, one number after the other. */
function lobeOf({ latents, table }: Material): Float32Array<ArrayBuffer> {
  const numbers = LOBE.NUMBERS[table.stretches ? 2 : 1].length;
  const codes = rows(latents, latents.length / CHANNELS);
  return Float32Array.from({ length: numbers * CHANNELS }, (_, at) => {
    const [number, channel] = [Math.floor(at / CHANNELS), at % CHANNELS];
    const isFactor = number >= 1 && number <= 3; // those of a lobe that reflects nothing are zero
    return isFactor && !table.besideLobe ? 0 : codes[channel][number];
  });
}

export class ShownMaterial {
  /** What is drawn in place of the table; null: the material is the same everywhere. */
  texels: TexelProgram | null = null;
  codes: ShownTexture | null = null;
  private readonly table: WebGLTexture;
  private sizes: DirectionSizes = { azimuths: 1, cosines: 1, samples: 0 };
  /** Angle by which the tangent is turned [radians]. */
  private rotation = 0;
  /** By which bright lights are reflected: the lobe, the table of the rest, and its stretches. */
  private material: Material | null = null;
  private lobe = new Float32Array(6 * CHANNELS).fill(1, 0, CHANNELS);
  private readonly rest: WebGLTexture;
  private stretches: readonly number[] = [1, 1, 1];

  constructor(private readonly gl: Gl) {
    this.table = gl.createTexture()!;
    const nothing = new Float32Array(4 * NODES).fill(-18); // until f is known
    this.rest = volume(gl, gl.createTexture()!, nothing);
  }

  /** Whether the program for anisotropic materials draws it. */
  get isAnisotropic(): boolean {
    return this.sizes.azimuths > 1;
  }

  /**
   * Take over a table of directions (azimuths, cosines, samples, 8).
   *
   * @param rotation angle by which the material's tangent is turned [degrees].
   * @param isFirst as in `directionTexels`.
   */
  setTable(table: Float32Array, sizes: DirectionSizes, rotation: number, isFirst: boolean): void {
    const { gl } = this;
    this.sizes = sizes;
    this.rotation = (rotation * Math.PI) / 180;
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, this.table);
    const [columns, lines] = [sizes.azimuths * sizes.cosines, 2 * sizes.samples + 2];
    const texels = directionTexels(table, sizes, isFirst);
    const target = gl.TEXTURE_2D;
    gl.texImage2D(target, 0, gl.RGBA32F, columns, lines, 0, gl.RGBA, gl.FLOAT, texels);
    filters(gl, target, gl.NEAREST, gl.NEAREST, gl.CLAMP_TO_EDGE);
  }

  /** Take over codes and table, by which it reflects bright lights. */
  setMaterial(material: Material): void {
    if (material === this.material) return;
    this.material = material;
    this.lobe = lobeOf(material);
    this.stretches = (material.table.stretches ?? [0, 0, 0]).map(Math.exp);
    volume(this.gl, this.rest, tableTexels(material.table));
  }

  /**
   * Take over a texture of codes and its shader code, or none.
   *
   * @throws Refusal if it is too large for the graphics driver.
   */
  setTexels(codes: ShownTexture | null): void {
    if (codes === this.codes) return;
    this.codes = codes;
    const { gl, texels } = this;
    this.texels = null;
    if (texels !== null) {
      gl.deleteTexture(texels.texture);
      gl.deleteTexture(texels.basis);
      texels.program.delete();
    }
    this.texels = codes && texelProgram(gl, codes);
  }

  /**
   * What a program reads of the material.
   *
   * @param count frames that precede it.
   * @param share share of the directions that is taken, in (0, 1].
   */
  uniforms(count: number, share: number): Uniforms {
    const { texels, sizes, table, rest, lobe, rotation, stretches } = this;
    const samples = texels
      ? Math.max(4, Math.round(TEXEL_SAMPLES * share))
      : Math.max(16, Math.round(sizes.samples * share));
    const detail = { samples, density: samples * (count + 1), footprint: 1 / Math.sqrt(count + 1) };
    if (texels) {
      const start = sequencePoint(count * TEXEL_SAMPLES, [0.5, 0.5, 0.5]);
      return { ...detail, start, codes: texels.texture, functions: texels.basis };
    }
    return { ...detail, table, rest, lobe, azimuths: sizes.azimuths, rotation, stretches };
  }
}
