/** Small pictures of materials, drawn when they are first looked at. */

import type { MaterialCards } from "../material/material";
import { Renderer } from "../picture/renderer";
import type { Shot } from "../picture/shot";
import { INITIAL } from "../state/state";
import { TABLE_SIZES } from "./engine";
import { shownOf, startedSession } from "./session";

const SHOT: Shot = {
  ...INITIAL,
  view: { ...INITIAL.view, elevation: 12, zoom: 1.2 },
  slot: 0,
};

/** Width and height [pixels]. */
export const THUMBNAIL_SIZE = 112;

/** What was drawn; null: the browser or the material has no picture. */
const drawn = new WeakMap<MaterialCards, Promise<ImageBitmap | null>>();
/** One is drawn after the other, by one renderer, which is given back at last. */
let last: Promise<unknown> = Promise.resolve();
let waiting = 0;
let renderer: Renderer | null = null;

/** The picture of a material on a ball; null if there is none. The same object is drawn once. */
export function thumbnailOf(material: MaterialCards): Promise<ImageBitmap | null> {
  let picture = drawn.get(material);
  if (picture === undefined) {
    waiting++;
    picture = last
      .then(() => draw(material))
      .catch(() => {
        drawn.delete(material); // another try may succeed
        return null;
      });
    drawn.set(material, picture);
    last = picture.then(() => {
      if (--waiting > 0) return;
      renderer?.dispose();
      renderer = null;
    });
  }
  return picture;
}

async function draw(material: MaterialCards): Promise<ImageBitmap | null> {
  const { cores } = await startedSession();
  const shown = shownOf(material);
  if (shown === null) return null;
  const { core, material: codes } = await cores.material(shown);
  const sizes = TABLE_SIZES[core.widths];
  const table = await core.table(codes, { ...sizes, shift: [0, 0, 0] });
  if (renderer === null) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [THUMBNAIL_SIZE, THUMBNAIL_SIZE];
    renderer = new Renderer(canvas);
    renderer.setEnvironment("studio", null);
  }
  const drawnBy = renderer.material(0);
  drawnBy.setTexels(shown.texture);
  drawnBy.setTable(table, sizes, shown.rotation, true);
  renderer.draw(SHOT);
  return createImageBitmap(renderer.canvas);
}
