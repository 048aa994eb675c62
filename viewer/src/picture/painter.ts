/** When the picture is drawn, how large, and with which tables: at once, then ever better. */

import { signal } from "@preact/signals";
import { MOST_TABLES, type Slot, TABLE_SIZES } from "../engine/engine";
import { Refusal } from "../refusal";
import type { Renderer } from "./renderer";
import type { Shot } from "./shot";

/** Aims for a frame's time while something moves, and for a strip's time at rest [ms]. */
const MOVING = 25;
const RESTING = 60;

/** Time without change after which the picture rests [ms]. */
const PATIENCE = 160;

/** What a frame costs at first [ms for a million pixels], by the graphics card and by software. */
const FIRST_COST = { card: 60, software: 3000 };

/**
 * Least frames of a picture at rest where each takes long. Textures of codes, which are noisier, and
 * large pictures have the second number.
 */
const [SLOW_FRAMES, MORE_SLOW_FRAMES] = [3, 6];
/** Shaded pixels of all frames of such a picture on the page. */
const SLOW_PIXELS = 0.5e6;

/** Frames for one of a table, where a texture of codes is decoded: they have fewer directions. */
const TEXTURE_FRAMES = 3;

const MOST_STRIPS = 32;

/** Ever cheaper frames: width of the shading relative to the canvas, and share of the directions. */
const SAVINGS = [
  [1, 1],
  [0.75, 1],
  [0.5, 1],
  [0.5, 0.5],
  [0.25, 0.5],
  [0.25, 0.25],
] as const;

export class Painter {
  /** Share of the frames that are gathered at rest, and whether no more will come. */
  readonly gathered = signal(0);
  readonly converged = signal(false);
  /** Colour differences (CIELAB) of two pictures; null: none are compared so. */
  readonly difference = signal<{ mean: number; largest: number } | null>(null);
  /** What the picture at rest waits for, since it would have to be drawn anew. */
  ready: Promise<unknown> = Promise.resolve();
  private renderer: Renderer | null = null;
  private shot: Shot | null = null;
  /** Milliseconds for a million shaded pixels: previews, which shade few, take most for all else. */
  private readonly cost = { moving: 0, resting: 0 };
  private slow = false;
  private changedAt = Number.NEGATIVE_INFINITY;
  private dirty = true;
  private running = false;
  /** Ends the wait for the picture to rest. */
  private wake = (): void => {};
  private count = 0;
  private resting = false;
  private readonly uploaded: [string, string] = ["", ""];

  constructor(
    private readonly slots: readonly [Slot, Slot],
    private readonly failed: (error: unknown) => void,
  ) {}

  /** Draw by a renderer from now on; null: the context is lost. */
  setRenderer(renderer: Renderer | null): void {
    this.renderer = renderer;
    this.uploaded.fill("");
    this.slow = renderer?.isSoftware ?? false;
    const first = this.slow ? FIRST_COST.software : FIRST_COST.card;
    Object.assign(this.cost, { moving: first, resting: first });
    this.refresh();
  }

  setShot(shot: Shot): void {
    const { shot: before, renderer } = this;
    this.shot = shot;
    const isDrawn = before !== null && this.count > 0 && lightOf(before) === lightOf(shot);
    if (isDrawn && renderer !== null) {
      renderer.show(shot);
      this.measure(renderer, shot);
    } else this.refresh();
  }

  /** Compare the two pictures of a difference. */
  private measure(renderer: Renderer, shot: Shot): void {
    this.difference.value = shot.comparison === "difference" ? renderer.difference(shot) : null;
  }

  /**
   * The renderer, once it has a picture at the canvas's full size.
   *
   * @throws Refusal if none is being drawn.
   */
  async whole(): Promise<Renderer> {
    while (this.count === 0 && this.running) await new Promise(requestAnimationFrame);
    if (this.renderer === null || this.count === 0) throw noPictureYet();
    return this.renderer;
  }

  /** The picture is out of date. */
  refresh(): void {
    this.dirty = true;
    this.changedAt = performance.now();
    this.count = 0;
    this.resting = false;
    this.gathered.value = 0;
    this.converged.value = false;
    this.wake();
    void this.run();
  }

  private async run(): Promise<void> {
    if (this.running) return;
    this.running = true;
    try {
      await null; // changes often come together
      while (await this.step()) await new Promise(requestAnimationFrame);
    } catch (error) {
      this.failed(error);
    } finally {
      this.running = false;
    }
  }

  /** Draw what is next; returns false when nothing is left to do. */
  private async step(): Promise<boolean> {
    const { renderer, shot } = this;
    if (renderer === null || shot === null) return false;
    const slots = shownSlots(shot);
    if (slots.some((slot) => this.slots[slot].tables.length === 0)) return false;
    if (this.dirty) {
      this.dirty = false;
      await this.preview(renderer, shot, slots);
      return true;
    }
    const wait = this.changedAt + PATIENCE - performance.now();
    if (wait > 0) {
      await new Promise<void>((resolve) => {
        this.wake = resolve;
        setTimeout(resolve, wait);
      });
      return true;
    }
    return this.rest(renderer, shot, slots);
  }

  /** Draw the next frame at rest. */
  private async rest(renderer: Renderer, shot: Shot, slots: (0 | 1)[]): Promise<boolean> {
    if (!this.resting) {
      await this.ready;
      if (this.dirty) return true;
      this.resting = true;
      this.count = 0;
    }
    const { frames } = this.plan(renderer, shot);
    if (this.count >= frames) {
      this.converged.value = true;
      return false;
    }
    for (const slot of slots)
      if (this.slots[slot].texture === null && this.slots[slot].tables.length <= this.count) {
        const grown = await this.slots[slot].another();
        if (!grown || !this.resting) return true;
      }
    if (await this.improve(renderer, shot, slots)) {
      this.count++;
      this.gathered.value = this.count / frames;
    }
    return true;
  }

  /** Frames of a picture at rest, and the width of their shading relative to the canvas. */
  private plan(renderer: Renderer, shot: Shot): { frames: number; scale: number } {
    const isTexture = shownSlots(shot).every((slot) => this.slots[slot].texture !== null);
    const most = isTexture ? TEXTURE_FRAMES * MOST_TABLES : MOST_TABLES;
    if (!this.slow) return { frames: most, scale: 1 };
    const whole = SLOW_PIXELS / renderer.pixels(shot);
    const least = isTexture || shot.part ? MORE_SLOW_FRAMES : SLOW_FRAMES;
    const frames = Math.min(Math.max(Math.round(whole), least), most);
    return { frames, scale: shot.part ? 1 : Math.min(Math.sqrt(whole / frames), 1) };
  }

  /** Draw a frame at once, as large and with as many directions as time allows. */
  private async preview(renderer: Renderer, shot: Shot, slots: (0 | 1)[]): Promise<void> {
    const pixels = renderer.pixels(shot) / 1e6;
    const cheap = SAVINGS.find(
      ([scale, share]) => this.cost.moving * pixels * scale ** 2 * share < MOVING,
    );
    const [scale, share] = cheap ?? SAVINGS.at(-1)!;
    for (const slot of slots) this.upload(renderer, slot, null);
    renderer.draw(shot, scale, share);
    this.learn("moving", await renderer.finished(), pixels * scale ** 2 * share);
  }

  /** Gather a whole frame, strip by strip; false if something has changed meanwhile. */
  private async improve(renderer: Renderer, shot: Shot, slots: (0 | 1)[]): Promise<boolean> {
    const { scale } = this.plan(renderer, shot);
    const pixels = (renderer.pixels(shot) / 1e6) * scale ** 2;
    for (const slot of slots) this.upload(renderer, slot, this.count);
    const strips = Math.min(
      Math.max(Math.ceil((this.cost.resting * pixels) / RESTING), 1),
      MOST_STRIPS,
    );
    const start = performance.now();
    let before: Promise<unknown> | null = null;
    for (const _ of renderer.drawFrame(shot, this.count, scale, 1, strips)) {
      const drawn = renderer.finished();
      await before; // a strip is ready to be drawn when the one before it is finished
      if (!this.resting) return false;
      before = drawn;
    }
    await renderer.finished();
    this.measure(renderer, shot);
    this.learn("resting", performance.now() - start, pixels);
    return this.resting;
  }

  private learn(kind: "moving" | "resting", time: number, megapixels: number): void {
    this.cost[kind] += (Math.max(time, 0) / megapixels - this.cost[kind]) * 0.5;
  }

  /** Give a renderer what a frame needs; count: of those that precede it at rest, null: it moves. */
  private upload(renderer: Renderer, slot: 0 | 1, count: number | null): void {
    const { tables, generation, material, texture, widths, rotation } = this.slots[slot];
    const shown = renderer.material(slot);
    const table = tables[count ?? 0] ?? tables[0];
    const key = `${generation}.${count}`;
    if (table !== undefined && this.uploaded[slot] !== key) {
      shown.setTable(table, TABLE_SIZES[widths], rotation, count === null);
      this.uploaded[slot] = key;
    }
    shown.setTexels(texture);
    if (material !== null) shown.setMaterial(material);
  }
}

export function noPictureYet(): Refusal {
  return new Refusal("There is no picture to save.");
}

/** What decides the light of a shot: all but how it is displayed. */
function lightOf({ exposure, tone, background, scale, ...light }: Shot): string {
  return JSON.stringify([light, background === "environment"]);
}

/** The materials that a shot shows. */
function shownSlots(shot: Shot): (0 | 1)[] {
  return shot.comparison === "off" ? [shot.slot] : [0, 1];
}
