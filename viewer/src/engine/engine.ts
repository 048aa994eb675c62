/** Computes what the page shows of two materials: the latest change first, and only that. */

import { signal } from "@preact/signals";
import type { Material, Stack } from "../core/api";
import type { FTable } from "../core/f_table";
import { Pairs } from "../core/features";
import { lobeValues } from "../core/lobe";
import { sequenceSteps } from "../core/probe_pairs";
import type { Estimate } from "../core/walk/reference";
import {
  ANISOTROPIC_COARSE,
  ANISOTROPIC_FINE,
  type AnisotropicSize,
  anisotropicPairs,
} from "../picture/anisotropic_table";
import { Cancelled } from "../refusal";
import type { Cores, PageCore } from "./remote";
import type { ShownTexture } from "./textures";

/** Directions of each row of a table. */
export const SAMPLES = 128;

/** Azimuths and cosines of a table of an isotropic material, and of an anisotropic one. */
export const TABLE_ROWS = {
  1: { azimuths: 1, cosines: 32 },
  2: { azimuths: 8, cosines: 16 },
} as const;

/** Shifted tables whose mean the picture at rest is. */
export const MOST_TABLES = 48;

/** Angles of incidence at which the directional albedo is plotted [degrees]. */
export const ALBEDO_ANGLES = Float32Array.from({ length: 16 }, (_, k) => 5.9 * k);
const ALBEDO_COSINES = ALBEDO_ANGLES.map((degrees) => Math.cos((degrees * Math.PI) / 180));

/** Angles in the plane of incidence at which f is plotted [degrees]; positive beyond the normal. */
export const PLANE_ANGLES = Float32Array.from({ length: 241 }, (_, k) => (k - 120) * 0.745);

/** Angles at which the walk is compared with the networks [degrees]. */
export const WALK_ANGLES = Float32Array.from({ length: 33 }, (_, k) => (k - 16) * 5);

/** Walks of a comparison. */
const MOST_WALKS = 4096;

/** Time without change after which what is slow is computed [ms]. */
const PATIENCE = 200;

/** The walk's values in the plane of incidence, beside those of the networks. */
export interface Comparison {
  walks: number;
  /** (N, 3) at `WALK_ANGLES`. */
  f: Float32Array;
  error: Float32Array;
  /** The networks' deviation, and the walk's standard error. */
  whole: Difference;
  /** The same of what the topmost surface does not reflect, whose highlight is exact. */
  rest: Difference;
}

/** A deviation and a standard error, relative to the sum of f cos. */
export interface Difference {
  deviation: number;
  noise: number;
}

/** Values of f of two widths for the bright lights, and the table's size. */
export interface Bright {
  f: Float32Array;
  size: AnisotropicSize;
}

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
  /** The plots' angle of incidence [degrees]. */
  incidence: () => number;
  /** Whether the plots show this slot. */
  plotted: () => boolean;
}

/** What is known of one material. */
export class Slot {
  /** Counts the materials that this slot had. */
  generation = 0;
  /** Shifted tables, whose mean the picture at rest is; the first is shown at once. */
  tables: Float32Array[] = [];
  bright: Bright | null = null;
  /** Decoded at each pixel; null: the material is the same everywhere. */
  texture: ShownTexture | null = null;
  /** f (N, 3) at `PLANE_ANGLES`, and the directional albedo (N, 3) at `ALBEDO_ANGLES`. */
  readonly plane = signal<Float32Array | null>(null);
  readonly albedo = signal<Float32Array | null>(null);
  /** The walk so far; null: there is none. */
  readonly walk = signal<Comparison | null>(null);
  /** GGX widths of the networks, and the angle by which the tangent is turned [degrees]. */
  widths: 1 | 2 = 1;
  rotation = 0;
  private core: PageCore;
  material: Material | null = null;
  private stack: Stack | null = null;
  private albedoIsOld = true;
  private timer = 0;
  private abort = new AbortController();
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

  /** Plot this slot, for the present angle of incidence. */
  async drawPlane(): Promise<void> {
    const { material } = this;
    if (material === null) return;
    this.walk.value = null;
    this.later();
    const pairs = planePairs(PLANE_ANGLES, this.page.incidence(), this.rotation);
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

  /** Compute f of two widths for the bright lights, at rest with more directions. */
  async light(fine: boolean): Promise<void> {
    const { material, generation } = this;
    const size = fine ? ANISOTROPIC_FINE : ANISOTROPIC_COARSE;
    const isEnough = this.bright !== null && (!fine || this.bright.size === size);
    if (material === null || this.widths === 1 || isEnough) return;
    const pairs = anisotropicPairs(size);
    const f = await this.core.f(material, pairs.wi, pairs.wo);
    if (generation !== this.generation || this.busy) return;
    this.bright = { f, size };
  }

  private async work(): Promise<void> {
    if (this.busy) return;
    this.busy = true;
    try {
      while (this.wanted !== null) {
        const { stack, texture, table, rotation } = this.wanted;
        this.wanted = null;
        this.abort.abort();
        this.walk.value = null;
        const core = await this.cores.of(stack);
        const layered = await core.layer(stack);
        const material = { ...layered, table: table ?? layered.table };
        const first = await this.table(core, material, 0);
        this.core = core;
        this.widths = core.widths;
        this.rotation = rotation;
        this.material = material;
        this.stack = stack;
        this.texture = texture;
        this.generation++;
        this.tables = [first];
        this.bright = null;
        this.page.changed();
        this.albedoIsOld = true;
        if (this.page.plotted()) await this.drawPlane();
      }
    } catch (error) {
      this.key = "";
      this.page.failed(error, () => this.show(this.latest!));
    } finally {
      this.busy = false;
    }
  }

  /** Compute what is slow when nothing has changed for a while. */
  private later(): void {
    clearTimeout(this.timer);
    this.abort.abort();
    this.abort = new AbortController();
    const { signal } = this.abort;
    const compute = async () => {
      const { material } = this;
      if (material === null || signal.aborted) return;
      if (this.albedoIsOld) {
        const albedo = await this.core.albedo(material, ALBEDO_COSINES);
        if (material !== this.material) return;
        this.albedo.value = albedo;
        this.albedoIsOld = false;
      }
      await this.compare(signal);
    };
    this.timer = setTimeout(() => compute().catch(this.page.failed), PATIENCE) as unknown as number;
  }

  /** Let the walk converge beside the networks. */
  private async compare(signal: AbortSignal): Promise<void> {
    const { material, stack } = this;
    const described = stack !== null && stack.bottom.kind !== "codes" && stack.coats.length > 0;
    const walkable = described && this.widths === 1; // the walk knows isotropic surfaces
    if (material === null || !walkable || stack.energyCompensation || signal.aborted) return;
    const pairs = planePairs(WALK_ANGLES, this.page.incidence(), 0);
    const networks = await this.core.f(material, ...pairs);
    const size = this.core.latentSize;
    const lobes = [0, 1, 2].map((channel) =>
      lobeValues(material.latents.subarray(channel * size), Pairs.of(...pairs)),
    );
    const show = (estimate: Estimate) => {
      if (!signal.aborted) this.walk.value = compared(estimate, networks, lobes);
    };
    try {
      const options = { seed: 1, walks: MOST_WALKS };
      show(await this.core.walk(stack, pairs, options, show, signal));
    } catch (error) {
      if (!(error instanceof Cancelled)) throw error;
    }
  }

  private table(core: PageCore, material: Material, place: number): Promise<Float32Array> {
    const sizes = { ...TABLE_ROWS[core.widths], samples: SAMPLES };
    return core.table(material, { ...sizes, shift: shiftOf(place) });
  }
}

/** The shift by which a table goes on where the one before it has ended. */
export function shiftOf(place: number): [number, number, number] {
  const [x, y, z] = sequenceSteps(3).map((step) => (step * SAMPLES * place) % 1) as [
    number,
    number,
    number,
  ];
  return [x, y, z];
}

/** Pairs in the plane of the shape's tangent, in the frame of a tangent turned by an angle. */
function planePairs(
  angles: Float32Array,
  incidence: number,
  rotation: number,
): [Float32Array, Float32Array] {
  const angle = (incidence * Math.PI) / 180;
  const turn = (rotation * Math.PI) / 180;
  const [x, y] = [Math.cos(turn), -Math.sin(turn)];
  const wi = new Float32Array(3 * angles.length);
  const wo = new Float32Array(3 * angles.length);
  angles.forEach((degrees, at) => {
    const out = (degrees * Math.PI) / 180;
    wi.set([-Math.sin(angle) * x, -Math.sin(angle) * y, Math.cos(angle)], 3 * at);
    wo.set([Math.sin(out) * x, Math.sin(out) * y, Math.cos(out)], 3 * at);
  });
  return [wi, wo];
}

function compared(
  { walks, f, error }: Estimate,
  networks: Float32Array,
  lobes: readonly Float64Array[],
): Comparison {
  let [deviation, noise, sum, lobe] = [0, 0, 0, 0];
  f.forEach((value, at) => {
    const place = Math.floor(at / 3);
    const cosine = Math.cos((WALK_ANGLES[place]! * Math.PI) / 180);
    deviation += Math.abs(networks[at]! - value) * cosine;
    noise += error[at]! * cosine;
    sum += value * cosine;
    lobe += lobes[at % 3]![place]! * cosine;
  });
  const over = (whole: number) => ({ deviation: deviation / whole, noise: noise / whole });
  return { walks, f, error, whole: over(sum), rest: over(Math.max(sum - lobe, 0)) };
}

function keyOf(stack: Stack): string {
  return JSON.stringify(stack, (_key, value) =>
    value instanceof Float32Array ? Array.from(value) : value,
  );
}
