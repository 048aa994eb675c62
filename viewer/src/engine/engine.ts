/** Computes what the page shows of two materials: the latest change first, and only that. */

import { signal } from "@preact/signals";
import type { Material, Stack } from "../core/api";
import { brightPairs, COARSE, FINE, type TableSize } from "../picture/bright_table";
import type { PageCore } from "./remote";

/** Numbers of cosines and of directions of a table. */
export const COSINES = 64;
export const SAMPLES = 128;

/** Shifted tables whose mean the picture at rest is. */
export const MOST_TABLES = 48;

/** Cosines at which the directional albedo is plotted, from the horizon to the normal. */
export const ALBEDO_COSINES = Float32Array.from({ length: 24 }, (_, k) => (k + 0.5) / 24);

/** Angles in the plane of incidence at which f is plotted [degrees]; positive beyond the normal. */
export const PLANE_ANGLES = Float32Array.from({ length: 241 }, (_, k) => (k - 120) * 0.745);

/** Values of f for the bright lights, and the table's size. */
export interface Bright {
  f: Float32Array;
  size: TableSize;
}

/** What is known of one material. */
export class Slot {
  /** Counts the materials that this slot had. */
  generation = 0;
  tables: Float32Array[] = [];
  bright: Bright | null = null;
  /** f (N, 3) at `PLANE_ANGLES`, and the directional albedo (N, 3) at `ALBEDO_COSINES`. */
  readonly plane = signal<Float32Array | null>(null);
  readonly albedo = signal<Float32Array | null>(null);
  private material: Material | null = null;
  private wanted: Stack | null = null;
  private busy = false;
  private key = "";

  constructor(
    private readonly core: PageCore,
    /** Called when there is something new to draw. */
    private readonly changed: () => void,
    private readonly failed: (error: unknown) => void,
    private readonly incidence: () => number,
  ) {}

  /** Show another stack as soon as possible. */
  show(stack: Stack): void {
    const key = keyOf(stack);
    if (key === this.key) return;
    this.key = key;
    this.wanted = stack;
    void this.work();
  }

  /** Compute f in the plane of incidence again, for another angle. */
  async drawPlane(): Promise<void> {
    const { material } = this;
    if (material === null) return;
    const f = await this.core.f(material, ...planePairs(this.incidence()));
    if (material === this.material) this.plane.value = f;
  }

  /** Compute the next shifted table; resolves to false if there is nothing to do. */
  async another(): Promise<boolean> {
    const { material, generation } = this;
    if (material === null || this.busy || this.tables.length >= MOST_TABLES) return false;
    const table = await this.table(material, this.tables.length);
    if (generation !== this.generation || this.wanted !== null) return false;
    this.tables.push(table);
    return true;
  }

  /** Compute f for the bright lights, at rest with more directions. */
  async light(fine: boolean): Promise<void> {
    const { material, generation } = this;
    const size = fine ? FINE : COARSE;
    if (material === null || (this.bright !== null && (!fine || this.bright.size === FINE))) return;
    const pairs = brightPairs(size);
    const f = await this.core.f(material, pairs.wi, pairs.wo);
    if (generation !== this.generation || this.wanted !== null) return;
    this.bright = { f, size };
  }

  private async work(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.wanted !== null) {
        const stack = this.wanted;
        this.wanted = null;
        const material = await this.core.layer(stack);
        const table = await this.table(material, 0);
        this.material = material;
        this.generation++;
        this.tables = [table];
        this.bright = null;
        this.changed();
        const [plane, albedo] = await Promise.all([
          this.core.f(material, ...planePairs(this.incidence())),
          this.core.albedo(material, ALBEDO_COSINES),
        ]);
        this.plane.value = plane;
        this.albedo.value = albedo;
      }
    } catch (error) {
      this.failed(error);
    } finally {
      this.busy = false;
    }
  }

  private table(material: Material, place: number): Promise<Float32Array> {
    return this.core.table(material, {
      cosines: COSINES,
      samples: SAMPLES,
      shift: shiftOf(place),
    });
  }
}

/** Shifts that fill the cube evenly (Roberts 2018); the first is none. */
export function shiftOf(place: number): [number, number, number] {
  return [
    (0.8191725133961645 * place) % 1,
    (0.6710436067037893 * place) % 1,
    (0.5497004779019703 * place) % 1,
  ];
}

function planePairs(incidence: number): [Float32Array, Float32Array] {
  const angle = (incidence * Math.PI) / 180;
  const wi = new Float32Array(3 * PLANE_ANGLES.length);
  const wo = new Float32Array(3 * PLANE_ANGLES.length);
  PLANE_ANGLES.forEach((degrees, at) => {
    const out = (degrees * Math.PI) / 180;
    wi.set([-Math.sin(angle), 0, Math.cos(angle)], 3 * at);
    wo.set([Math.sin(out), 0, Math.cos(out)], 3 * at);
  });
  return [wi, wo];
}

function keyOf(stack: Stack): string {
  return JSON.stringify(stack, (_key, value) =>
    value instanceof Float32Array ? Array.from(value) : value,
  );
}
