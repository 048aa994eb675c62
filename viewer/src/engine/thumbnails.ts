/** Small pictures of the presets, drawn when they are first looked at. */

import { stackOf } from "../material/material";
import { PRESETS } from "../material/presets";
import { NoGraphics } from "../picture/gl";
import { Renderer, type Shot } from "../picture/renderer";
import { SAMPLES, TABLE_ROWS } from "./engine";
import { session } from "./session";

const SHOT: Shot = {
  view: { azimuth: 20, elevation: 12, zoom: 1.2 },
  rotation: 0,
  exposure: 0,
  comparison: "off",
  slot: 0,
  edge: 0.5,
  scale: 50,
};

/** What was drawn, in the order of the presets. */
const drawn: ImageBitmap[] = [];
let begun = false;

/** Fill the canvases, as long as they are seen. */
export async function drawThumbnails(
  canvases: HTMLCanvasElement[],
  seen: () => boolean,
): Promise<void> {
  if (!begun) void draw();
  begun = true;
  for (let shown = 0; shown < canvases.length && seen(); ) {
    const picture = drawn[shown];
    if (picture !== undefined) canvases[shown++]!.getContext("2d")?.drawImage(picture, 0, 0);
    else await new Promise((resolve) => setTimeout(resolve, 30));
  }
}

async function draw(): Promise<void> {
  try {
    await drawAll();
  } catch (error) {
    if (!(error instanceof NoGraphics)) throw error;
  }
}

async function drawAll(): Promise<void> {
  const cores = session.value?.cores;
  if (cores === undefined) return;
  const canvas = document.createElement("canvas");
  canvas.width = 112;
  canvas.height = 112;
  const renderer = new Renderer(canvas);
  renderer.setEnvironment("studio", null);
  for (const preset of PRESETS) {
    const stack = stackOf(preset);
    const core = await cores.of(stack);
    const material = await core.layer(stack);
    const sizes = { ...TABLE_ROWS[core.widths], samples: SAMPLES };
    const table = await core.table(material, { ...sizes, shift: [0, 0, 0] });
    renderer.setTable(0, table, sizes, preset.rotation, true);
    renderer.draw(SHOT);
    drawn.push(await createImageBitmap(canvas));
  }
  renderer.dispose();
}
