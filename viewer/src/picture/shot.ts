/** What a frame shows, and where: its panes, their parts, and the shifts of frames. */

import type { State } from "../state/state";

/** What a frame shows. */
export interface Shot
  extends Pick<
    State,
    "view" | "rotation" | "exposure" | "tone" | "background" | "comparison" | "edge" | "scale"
  > {
  /** The material that is shown alone. */
  slot: 0 | 1;
  /** Of a picture of `count` by `count` parts, each as large as the canvas: the one that is drawn. */
  part?: { count: number; column: number; row: number };
}

export const WHOLE = { count: 1, column: 0, row: 0 };

/** The part of the picture that a material fills [pixels], and the part of it that is drawn. */
interface Pane {
  slot: 0 | 1;
  x: number;
  width: number;
  from: number;
  to: number;
  /** Place of its picture in the frame. */
  offset: number;
}

/** A part of a frame: its lower left corner, width and height [pixels]. */
export type Box = [x: number, y: number, width: number, height: number];

/** The part of another size of a frame that has what a part shows, and a margin. */
export function around([x, y, width, height]: Box, scale: number, margin: number): Box {
  const [left, low] = [Math.floor(x * scale) - margin, Math.floor(y * scale) - margin];
  const right = Math.ceil((x + width) * scale) + margin;
  return [left, low, right - left, Math.ceil((y + height) * scale) + margin - low];
}

/** The panes of a picture, left to right; `partWidth`: of the part that is drawn. */
export function panes(shot: Shot, width: number, partWidth: number): Pane[] {
  const half = Math.floor(width / 2);
  const edge = Math.round(width * shot.edge);
  const [first, second] = ([0, 1] as const).map(
    (slot): Pane => ({ slot, x: 0, width, from: 0, to: width, offset: 0 }),
  ) as [Pane, Pane];
  switch (shot.comparison) {
    case "off":
      return [{ ...first, slot: shot.slot }];
    case "side":
      return [
        { ...first, width: half, to: half },
        { ...second, x: half, width: width - half, from: half },
      ];
    case "difference": // of two pictures beside each other
      return [first, { ...second, offset: partWidth }];
    case "swipe":
      return [
        { ...first, to: edge },
        { ...second, from: edge },
      ];
  }
}

/** The shift of a frame by parts of a pixel, by how many precede it. */
export function shiftOf(count: number): [number, number] {
  return count === 0 ? [0, 0] : [halton(count, 2) - 0.5, halton(count, 3) - 0.5];
}

/** A number of Halton's sequence. */
function halton(place: number, base: number): number {
  let value = 0;
  let share = 1;
  for (let rest = place; rest > 0; rest = Math.floor(rest / base)) {
    share /= base;
    value += share * (rest % base);
  }
  return value;
}
