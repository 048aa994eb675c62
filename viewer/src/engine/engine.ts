/** Computes what the page shows of two materials: the latest change first, and only that. */

import { signal } from "@preact/signals";
import type { Material, Stack } from "../core/api";
import type { FTable } from "../core/f_table";
import { sequencePoint } from "../core/sequence";
import type { ShownTexture } from "./opened";
import type { Cores, PageCore } from "./remote";

/** Directions of each row of a table. */
const SAMPLES = 128;

/** Sizes of a table of an isotropic material, and of an anisotropic one. */
export const TABLE_SIZES = {
  1: { azimuths: 1, cosines: 32, samples: SAMPLES },
  2: { azimuths: 8, cosines: 16, samples: SAMPLES },
} as const;

/** Shifted tables whose mean the picture at rest is. */
export const MOST_TABLES = 48;

/** Angles of incidence at which the directional albedo is plotted [degrees]. */
export const ALBEDO_ANGLES = Float32Array.from({ length: 16 }, (_, k) => 5.9 * k);
const ALBEDO_COSINES = ALBEDO_ANGLES.map((degrees) => Math.cos((degrees * Math.PI) / 180));

/** Angles in the plane of incidence at which f is plotted [degrees]; positive beyond the normal. */
export const PLANE_ANGLES = Float32Array.from({ length: 241 }, (_, k) => (k - 120) * 0.745);

/** Time without change after which what is slow is computed [ms]. */
const PATIENCE = 200;

/** What a slot shows: a stack, whose f may be a table's, or a texture of codes whose mean it is. */
export interface Shown {
  stack: Stack;
  /** Angle by which the tangent is turned [degrees]. */
  rotation: number;
  texture: ShownTexture | null;
  table?: FTable | undefined;
}

/** What a slot knows of the page. */
export interface Surroundings {
  /** Called when there is something new to draw. */
  changed: () => void;
  /** Called with what another try does. */
  failed: (error: unknown, retry?: () => void) => void;
  /** The angle of incidence [degrees] of the plots; null: they do not show this slot. */
  incidence: () => number | null;
}

/** What is known of one material. */
export class Slot {
  /** Counts the materials that this slot had. */
  generation = 0;
  /** Shifted tables, whose mean the picture at rest is; the first is shown at once. */
  tables: Float32Array[] = [];
  /** Decoded at each pixel; null: the material is the same everywhere. */
  texture: ShownTexture | null = null;
  /** f (N, 3) at `PLANE_ANGLES`, and the directional albedo (N, 3) at `ALBEDO_ANGLES`. */
  readonly plane = signal<Float32Array | null>(null);
  readonly albedo = signal<Float32Array | null>(null);
  /** GGX widths of the networks, and the angle by which the tangent is turned [degrees]. */
  widths: 1 | 2 = 1;
  rotation = 0;
  private core: PageCore;
  material: Material | null = null;
  private albedoIsOld = true;
  private timer = 0;
  private wanted: Shown | null = null;
  private latest: Shown | null = null;
  private busy = false;
  private key = "";

  constructor(
    private readonly cores: Cores,
    private readonly page: Surroundings,
  ) {
    this.core = cores.isotropic;
  }

  /** Show another material as soon as possible. */
  show(shown: Shown): void {
    const key = `${shown.texture?.texture.id ?? ""}${shown.rotation}${keyOf(shown.stack)}`;
    if (key === this.key && shown.table?.logs === this.latest?.table?.logs) return;
    this.key = key;
    this.wanted = this.latest = shown;
    void this.work();
  }

  /** Plot this slot, for the present angle of incidence, if the plots show it. */
  async drawPlane(): Promise<void> {
    const { material } = this;
    const incidence = this.page.incidence();
    if (material === null || incidence === null) return;
    this.later();
    const pairs = planePairs(incidence, this.rotation);
    const f = await this.core.f(material, ...pairs);
    if (material === this.material) this.plane.value = f;
  }

  /** A copy that keeps its material when this slot gets another one. */
  frozen(): Slot {
    const copy: Slot = Object.create(Slot.prototype);
    return Object.assign(copy, this, { tables: [...this.tables], busy: false });
  }

  /** Compute the next shifted table; resolves to false if there is nothing to do. */
  async another(): Promise<boolean> {
    const { material, generation } = this;
    if (material === null || this.busy || this.tables.length >= MOST_TABLES) return false;
    const table = await this.table(this.core, material, this.tables.length);
    if (generation !== this.generation || this.busy) return false;
    this.tables.push(table);
    return true;
  }

  private async work(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    while (this.wanted !== null) {
      const shown = this.wanted;
      this.wanted = null;
      try {
        await this.compute(shown);
      } catch (error) {
        if (this.wanted !== null) continue; // nobody waits for it any more
        this.key = "";
        this.page.failed(error, () => this.show(this.latest!));
      }
    }
    this.busy = false;
  }

  private async compute(shown: Shown): Promise<void> {
    const { core, material } = await this.cores.material(shown);
    const first = await this.table(core, material, 0);
    this.core = core;
    this.widths = core.widths;
    this.rotation = shown.rotation;
    this.material = material;
    this.texture = shown.texture;
    this.generation++;
    this.tables = [first];
    this.page.changed();
    this.albedoIsOld = true;
    await this.drawPlane();
  }

  /** Compute the albedo, which is slow, when nothing has changed for a while. */
  private later(): void {
    clearTimeout(this.timer);
    const compute = async () => {
      const { material } = this;
      if (material === null || !this.albedoIsOld) return;
      const albedo = await this.core.albedo(material, ALBEDO_COSINES);
      if (material !== this.material) return;
      this.albedo.value = albedo;
      this.albedoIsOld = false;
    };
    this.timer = setTimeout(() => compute().catch(this.page.failed), PATIENCE) as unknown as number;
  }

  private table(core: PageCore, material: Material, place: number): Promise<Float32Array> {
    // The sequence goes on where the table before has ended.
    const shift = sequencePoint(SAMPLES * place, [0, 0, 0]);
    return core.table(material, { ...TABLE_SIZES[core.widths], shift });
  }
}

/** Pairs in the plane of the shape's tangent, in the frame of a tangent turned by an angle. */
function planePairs(incidence: number, rotation: number): [Float32Array, Float32Array] {
  const angle = (incidence * Math.PI) / 180;
  const turn = (rotation * Math.PI) / 180;
  const [x, y] = [Math.cos(turn), -Math.sin(turn)];
  const wi = new Float32Array(3 * PLANE_ANGLES.length);
  const wo = new Float32Array(3 * PLANE_ANGLES.length);
  PLANE_ANGLES.forEach((degrees, at) => {
    const out = (degrees * Math.PI) / 180;
    wi.set([-Math.sin(angle) * x, -Math.sin(angle) * y, Math.cos(angle)], 3 * at);
    wo.set([Math.sin(out) * x, Math.sin(out) * y, Math.cos(out)], 3 * at);
  });
  return [wi, wo];
}

function keyOf(stack: Stack): string {
  return JSON.stringify(stack, (_key, value) =>
    value instanceof Float32Array ? Array.from(value) : value,
  );
}
