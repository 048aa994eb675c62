/** Pictures that are larger than the canvas, drawn in parts by a renderer of their own. */

import { effect, signal } from "@preact/signals";
import { Painter } from "../picture/painter";
import { Renderer, type Shot } from "../picture/renderer";
import { Refusal } from "../refusal";
import type { Slot } from "./engine";

/** Twice the canvas, or 3840 pixels along the longer side. */
export type LargeSize = "2x" | "4K";

const LONGER_SIDE = 3840;

/** How much of a large picture is drawn, from 0 to 1; null: there is none. */
export const drawn = signal<number | null>(null);

/**
 * The picture of a shot, gathered to the end, as PNG.
 *
 * @param canvas size of the page's picture [pixels].
 * @param slots nobody else may change them.
 * @param prepare gives a renderer the object and the environment.
 * @throws Refusal if another one is being drawn; NoGraphics
 */
export async function drawLarge(
  size: LargeSize,
  canvas: { width: number; height: number },
  slots: readonly [Slot, Slot],
  shot: Shot,
  prepare: (renderer: Renderer) => void,
): Promise<Blob> {
  if (drawn.value !== null) throw new Refusal("A picture is being drawn; save it first.");
  drawn.value = 0;
  const { count, width, height } = partsOf(size, canvas);
  const part = Object.assign(document.createElement("canvas"), { width, height });
  const whole = document.createElement("canvas");
  whole.width = count * width;
  whole.height = count * height;
  let renderer: Renderer | null = null;
  try {
    renderer = new Renderer(part);
    prepare(renderer);
    for (let at = 0; at < count ** 2; at++) {
      const [column, row] = [at % count, Math.floor(at / count)];
      await gathered(renderer, slots, { ...shot, part: { count, column, row } }, (share) => {
        drawn.value = (at + share) / count ** 2;
      });
      whole.getContext("2d")!.drawImage(part, column * width, (count - 1 - row) * height);
    }
    return await blobOf(whole);
  } finally {
    renderer?.dispose();
    drawn.value = null;
  }
}

/** Parts along each side of a large picture, and the size of one [pixels]. */
export function partsOf(size: LargeSize, { width, height }: { width: number; height: number }) {
  if (size === "2x") return { count: 2, width, height };
  const longer = Math.max(width, height);
  let count = 1;
  while (LONGER_SIDE % count !== 0 || LONGER_SIDE / count > longer) count++;
  const scaled = (side: number) => Math.max(Math.round((LONGER_SIDE / count / longer) * side), 1);
  return { count, width: scaled(width), height: scaled(height) };
}

/** Wait until a renderer shows a shot that has converged; told: share of its frames. */
function gathered(
  renderer: Renderer,
  slots: readonly [Slot, Slot],
  shot: Shot,
  told: (share: number) => void,
): Promise<void> {
  return new Promise((resolve, reject) => {
    const painter = new Painter(slots, reject);
    painter.setRenderer(renderer);
    painter.setShot(shot);
    effect(() => {
      told(painter.gathered.value);
      if (painter.converged.value) resolve();
    });
  });
}

/** A canvas's picture as PNG. */
export async function blobOf(canvas: HTMLCanvasElement): Promise<Blob> {
  return (await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve)))!;
}
