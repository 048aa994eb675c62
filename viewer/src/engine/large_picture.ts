/** Pictures that are larger than the canvas, drawn in parts by a renderer of their own. */

import { effect } from "@preact/signals";
import { Painter } from "../picture/painter";
import { Renderer } from "../picture/renderer";
import type { Shot } from "../picture/shot";
import { Cancelled, Refusal } from "../refusal";
import { asTask } from "../state/store";
import type { Slot } from "./engine";

/** Twice the canvas, or 3840 pixels along the longer side. */
export type LargeSize = "2x" | "4K";

const LONGER_SIDE = 3840;

/**
 * The picture of a shot, gathered to the end, as PNG.
 *
 * @param canvas size of the page's picture [pixels].
 * @param slots nobody else may change them.
 * @param prepare gives a renderer the object and the environment.
 * @throws Refusal if the page does something else; Cancelled, NoGraphics
 */
export function drawLarge(
  size: LargeSize,
  canvas: { width: number; height: number },
  slots: readonly [Slot, Slot],
  shot: Shot,
  prepare: (renderer: Renderer) => void,
): Promise<Blob> {
  const { count, width, height } = partsOf(size, canvas);
  return asTask("Drawing the large picture", async (end, told) => {
    const part = Object.assign(document.createElement("canvas"), { width, height });
    const whole = document.createElement("canvas");
    [whole.width, whole.height] = [count * width, count * height];
    const renderer = new Renderer(part);
    try {
      prepare(renderer);
      for (let at = 0; at < count ** 2; at++) {
        const [column, row] = [at % count, Math.floor(at / count)];
        const ofPart = (share: number) => told((at + share) / count ** 2);
        await gathered(renderer, slots, { ...shot, part: { count, column, row } }, ofPart, end);
        whole.getContext("2d")!.drawImage(part, column * width, (count - 1 - row) * height);
      }
      return await blobOf(whole);
    } finally {
      renderer.dispose();
    }
  });
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
  end: AbortSignal,
): Promise<void> {
  return new Promise((resolve, reject) => {
    const painter = new Painter(slots, reject);
    painter.setRenderer(renderer);
    painter.setShot(shot);
    end.addEventListener("abort", () => {
      painter.setRenderer(null);
      reject(new Cancelled());
    });
    effect(() => {
      told(painter.gathered.value);
      if (!painter.converged.value) return;
      if (renderer.isLost) reject(new Refusal("The graphics driver has ended it; save it again."));
      else resolve();
    });
  });
}

/**
 * A canvas's picture as PNG.
 *
 * @throws Refusal if it is too large.
 */
export async function blobOf(canvas: HTMLCanvasElement): Promise<Blob> {
  const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve));
  if (blob === null)
    throw new Refusal("The browser cannot save so large a picture; make the window smaller.");
  return blob;
}
