/** Random materials and states of the page, the same at every run. */

import type { MaterialCards } from "../../src/material/material";
import { readMaterial } from "../../src/state/read";
import {
  COMPARISONS,
  DIFFERENCE_SCALES,
  ENVIRONMENTS,
  INITIAL,
  OBJECTS,
  type State,
  TONES,
} from "../../src/state/state";

/** Draws of a seed (mulberry32). */
export class Draws {
  constructor(private seed: number) {}

  /** A number in [low, high), of few digits. */
  number(low = 0, high = 1): number {
    this.seed = (this.seed + 0x6d2b79f5) | 0;
    let t = Math.imul(this.seed ^ (this.seed >>> 15), 1 | this.seed);
    t = (t + Math.imul(t ^ (t >>> 7), 61 | t)) ^ t;
    const share = ((t ^ (t >>> 14)) >>> 0) / 2 ** 32;
    return Number((low + (high - low) * share).toPrecision(6));
  }

  /** True with a probability. */
  chance(probability: number): boolean {
    return this.number() < probability;
  }

  pick<T>(all: readonly T[]): T {
    return all[Math.floor(this.number() * all.length)];
  }

  /** One value, or one for each channel. */
  channels(draw: () => number): number | number[] {
    return this.chance(0.5) ? draw() : [draw(), draw(), draw()];
  }

  /** A material that can be layered; two: its surfaces may have two widths. */
  material(two = this.chance(0.3)): MaterialCards {
    const coats = Array.from({ length: this.pick([0, 1, 1, 2, 3, 4]) }, () => this.coat(two));
    const material = readMaterial({
      name: this.pick(["lacquer", "漆 – lacquer", ""]),
      bottom: this.bottom(two),
      coats,
      ...(this.chance(0.5) ? { energyCompensation: true } : {}),
      ...(this.chance(0.3) ? { rotation: this.number(-180, 180) } : {}),
    });
    return { ...material, solo: this.chance(0.1) ? this.pick([0, ...coats.keys()]) : null };
  }

  state(): State {
    return {
      ...INITIAL,
      materials: [this.material(), this.material()],
      active: this.pick([0, 1]),
      comparison: this.pick(COMPARISONS),
      edge: this.number(),
      scale: this.pick(DIFFERENCE_SCALES),
      object: this.pick([...OBJECTS, "own"]),
      mesh: this.pick(["", "chair é.obj"]),
      environment: this.pick(ENVIRONMENTS),
      rotation: this.number(-180, 180),
      exposure: this.number(-6, 6),
      view: {
        azimuth: this.number(-180, 180),
        elevation: this.number(-10, 85),
        zoom: this.number(0.5, 4),
        fov: this.number(5, 60),
        pan: [this.number(-2, 2), this.number(-2, 2)],
      },
      tone: this.pick(TONES),
      background: this.pick(["environment", "transparent", "#12ab9f"]),
      plots: this.chance(0.5),
      incidence: this.number(0, 89),
    };
  }

  private widths(two: boolean): object {
    const alpha = this.number(0.1) ** 2;
    if (!two || this.chance(0.4)) return { alpha };
    const across = alpha * 10 ** this.number(-0.9, 0.9);
    return { alpha, alphaV: Math.min(Math.max(across, 0.01), 1) };
  }

  private coat(two: boolean): object {
    const share = () => this.number();
    const medium = this.pick<() => object>([
      () => ({}),
      () => ({ color: this.channels(share) }),
      () => ({ body: this.channels(share), bodyColor: this.channels(share) }),
      () => ({ albedo: this.channels(share), sigmaT: this.channels(() => 8 * share() ** 2) }),
    ])();
    return {
      ...this.widths(two),
      ior: this.chance(0.3) ? 1.5 : this.channels(() => this.number(0.51, 3)),
      g: this.chance(0.5) ? 0 : this.channels(() => this.number(-0.9, 0.9)),
      ...medium,
      ...(this.chance(0.3) ? { thickness: this.number(0, 2) } : {}),
      on: !this.chance(0.1),
    };
  }

  private bottom(two: boolean): object {
    const number = (low: number, high: number) => this.channels(() => this.number(low, high));
    return this.pick([
      () => ({ kind: "conductor", ...this.widths(two), r0: number(0, 1) }),
      () => ({ kind: "conductor", ...this.widths(two), eta: number(0.1, 4), k: number(0.5, 9) }),
      () => ({ kind: "dielectric", ...this.widths(two), ior: number(0.6, 3) }),
      () => ({ kind: "diffuse", reflectance: number(0, 1) }),
    ])();
  }
}
