/** What lives as long as the page: the core, two materials, the picture, and what binds them. */

import { computed, effect, type ReadonlySignal, signal } from "@preact/signals";
import type { Stack } from "../core/api";
import type { FTable } from "../core/f_table";
import { TensorFile } from "../core/safetensors";
import { type MaterialCards, stackOf } from "../material/material";
import { meanCodes } from "../material/texture";
import { lightsOf } from "../picture/environment";
import { NoGraphics } from "../picture/gl";
import type { Mesh } from "../picture/meshes";
import { noPictureYet, Painter } from "../picture/painter";
import type { Picture } from "../picture/panorama";
import { Renderer } from "../picture/renderer";
import type { Shot } from "../picture/shot";
import { Refusal } from "../refusal";
import { exrFile } from "../save/exr";
import type { Scene } from "../save/scene";
import { readState } from "../state/read";
import { announce, complain, look, showRead, state } from "../state/store";
import { type Shown, Slot } from "./engine";
import { readFile } from "./files";
import { blobOf, drawLarge, type LargeSize } from "./large_picture";
import { readMaterialFile } from "./material_file";
import {
  keepTable,
  keepTexture,
  logsOfBytes,
  lost,
  meshOfState,
  occlusionOf,
  panoramaOf,
  tables,
  textures,
} from "./opened";
import { Cores, connect, once } from "./remote";

/** Whether the light that the object hides is being computed. */
export const occluding = signal(false);

/** What keeps the picture from being drawn, or "". */
export const noPicture = signal("");

/** Whether the networks are being loaded. */
export const loading = signal(true);

export class Session {
  readonly slots: readonly [Slot, Slot];
  readonly painter: Painter;

  private readonly mesh: ReadonlySignal<Mesh>;
  private readonly shot = computed<Shot>(() => {
    const { view, rotation, exposure, tone, background, comparison, edge, scale } = state.value;
    const slot = state.value.active;
    return { view, rotation, exposure, tone, background, comparison, edge, scale, slot };
  });
  private renderer: Renderer | null = null;
  private canvas: HTMLCanvasElement | null = null;

  constructor(readonly cores: Cores) {
    const slot = (place: 0 | 1) =>
      new Slot(cores, {
        changed: () => this.painter.refresh(),
        failed: complain,
        incidence: () => {
          const { plots, active, incidence } = state.peek();
          return plots && active === place ? incidence : null;
        },
      });
    this.slots = [slot(0), slot(1)];
    this.painter = new Painter(this.slots, complain);
    const object = computed(() => `${state.value.object} ${state.value.mesh}`);
    this.mesh = computed(() => {
      object.value; // other changes of the state keep the mesh
      return meshOfState(state.peek()).mesh;
    });
    this.bind();
  }

  /** Draw on a canvas from now on. */
  attach(canvas: HTMLCanvasElement): () => void {
    this.canvas = canvas;
    const lost = (event: Event) => {
      event.preventDefault();
      this.renderer = null;
      this.painter.setRenderer(null);
      noPicture.value =
        "The graphics driver has taken the picture away; it returns as soon as the driver allows.";
    };
    const end = new AbortController();
    canvas.addEventListener("webglcontextlost", lost, { signal: end.signal });
    canvas.addEventListener("webglcontextrestored", this.start, { signal: end.signal });
    const observer = new ResizeObserver(() => this.fit());
    observer.observe(canvas);
    this.fit();
    this.start();
    return () => {
      observer.disconnect();
      end.abort();
    };
  }

  private readonly start = (): void => {
    if (this.canvas === null) return;
    try {
      this.renderer = new Renderer(this.canvas);
      noPicture.value = "";
    } catch (error) {
      if (!(error instanceof NoGraphics)) throw error;
      noPicture.value = error.message;
      return;
    }
    this.show(this.mesh.peek());
    this.renderer.setEnvironment(state.peek().environment, panoramaOf(state.peek()));
    this.painter.setRenderer(this.renderer);
  };

  /** Show a mesh at once, and the light that it hides when that is known. */
  private show(mesh: Mesh): void {
    this.renderer?.setMesh(mesh);
    this.painter.refresh();
    occluding.value = true;
    const isShown = () => mesh === this.mesh.peek();
    this.painter.ready = occlusionOf(mesh)
      .then((occlusion) => {
        if (isShown()) this.renderer?.setOcclusion(occlusion);
      })
      .catch((error) => complain(error, () => this.show(this.mesh.peek())))
      .finally(() => {
        if (isShown()) occluding.value = false;
      });
  }

  /** The picture so far as linear radiance, before exposure and tone curve. */
  async radiance(): Promise<Picture> {
    return (await this.whole()).targets.read();
  }

  /** The renderer, once it has a whole picture at rest, whose light the object partly hides. */
  private async whole(): Promise<Renderer> {
    look({ turntable: false });
    await occlusionOf(this.mesh.peek());
    return this.painter.whole();
  }

  /** The picture so far as it is displayed. */
  async picture(): Promise<Blob> {
    await this.whole();
    return blobOf(this.canvas!);
  }

  /** A larger picture, as of `drawLarge`. */
  async largePicture(size: LargeSize): Promise<Blob> {
    const whole = await this.whole();
    const mesh = this.mesh.peek();
    const occlusion = await occlusionOf(mesh);
    const { environment } = state.peek();
    const own = panoramaOf(state.peek());
    const slots = [this.slots[0].frozen(), this.slots[1].frozen()] as const;
    return drawLarge(size, whole.canvas, slots, this.shot.peek(), (renderer) => {
      renderer.setMesh(mesh);
      renderer.setOcclusion(occlusion);
      renderer.setEnvironment(environment, own);
    });
  }

  /** What the picture shows, but the material. */
  async scene(): Promise<Omit<Scene, "material">> {
    if (this.renderer === null) throw noPictureYet();
    const { renderer } = this;
    const { view, rotation, environment: name } = state.peek();
    const { width, height } = renderer.canvas;
    const shown = { mesh: this.mesh.peek(), view, rotation, width, height };
    const own = panoramaOf(state.peek());
    if (own !== null) {
      const bytes = new Uint8Array(await own.file.arrayBuffer());
      const suffix = /\.exr$/i.test(own.file.name) ? "exr" : "hdr";
      return { ...shown, environment: { suffix, bytes }, lights: [] };
    }
    const bytes = exrFile(renderer.map.panoramaOf(name));
    return { ...shown, environment: { suffix: "exr", bytes }, lights: lightsOf(name) };
  }

  private fit(): void {
    if (this.canvas === null) return;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    const width = Math.max(1, Math.round(this.canvas.clientWidth * ratio));
    const height = Math.max(1, Math.round(this.canvas.clientHeight * ratio));
    if (width === this.canvas.width && height === this.canvas.height) return;
    this.canvas.width = width;
    this.canvas.height = height;
    this.painter.refresh();
  }

  private bind(): void {
    const { slots, painter } = this;
    const materials = computed(() => state.value.materials);
    const compared = computed(() => state.value.comparison !== "off");
    const active = computed(() => state.value.active);
    effect(() => {
      for (const slot of [0, 1] as const)
        if (compared.value || slot === active.value) {
          const shown = shownOf(materials.value[slot]);
          if (shown !== null) slots[slot].show(shown);
        }
    });

    const shown = computed(() => JSON.stringify(this.shot.value));
    effect(() => {
      shown.value; // other changes of the state keep the shot
      painter.setShot(this.shot.peek());
    });
    effect(() => {
      const mesh = this.mesh.value; // read here even while there is no renderer: it is followed
      this.show(mesh);
      if (meshOfState(state.peek()).isMissing)
        complain(new Refusal(lost(`mesh “${state.peek().mesh}”`)));
    });
    const environment = computed(() => state.value.environment);
    const own = computed(() => panoramaOf(state.value));
    effect(() => {
      const [name, panorama] = [environment.value, own.value];
      this.renderer?.setEnvironment(name, panorama);
      painter.refresh();
      if (name === "own" && panorama === null)
        complain(new Refusal(lost(`panorama “${state.peek().panorama}”`)));
    });
    const incidence = computed(() => state.value.incidence);
    const plots = computed(() => state.value.plots);
    effect(() => {
      [incidence.value, plots.value]; // followed
      slots[active.value].drawPlane().catch(complain);
    });
    effect(() => {
      if (painter.converged.value) announce("The picture has converged.");
    });
  }
}

/** The page's session, once the networks are there. */
export const session = signal<Session | null>(null);

/** The session, as soon as it is there. */
export async function startedSession(): Promise<Session> {
  while (session.peek() === null) await new Promise((resolve) => setTimeout(resolve, 100));
  return session.peek()!;
}

const isotropicCore = once(() => connect());

/** Load the networks and begin, with the material that the page was opened for unless `addressed`. */
export async function begin(addressed: boolean): Promise<void> {
  loading.value = true;
  try {
    const [core, start] = await Promise.all([isotropicCore(), readStart()]);
    if ("texture" in start) await keepTexture(await readBytes(String(start.texture)), core);
    if ("table" in start) keepTable(logsOfBytes(await readBytes(String(start.table))));
    if ("materials" in start && !addressed) showRead(() => readState(start), false);
    session.value = new Session(new Cores(core));
  } catch (error) {
    complain(error, () => void begin(addressed));
  } finally {
    loading.value = false;
  }
}

/** The file beside the page that describes its first material; it may be missing. */
async function readStart(): Promise<object> {
  const bytes = await readFile("start.json");
  return bytes === null ? {} : (JSON.parse(new TextDecoder().decode(bytes)) as object);
}

async function readBytes(path: string): Promise<Uint8Array<ArrayBuffer>> {
  const bytes = await readFile(path);
  if (bytes === null) throw new Refusal(`The file ${path} is missing beside the page.`);
  return bytes;
}

/** Materials that lie beside the page as files. */
export const stored = signal<readonly MaterialCards[]>([]);

const readAll = once(async () => {
  const { isotropic } = (await startedSession()).cores;
  const { stored: files = {} } = (await readStart()) as { stored?: Record<string, string> };
  for (const [name, path] of Object.entries(files).slice(stored.value.length)) {
    const { bottom } = readMaterialFile(new TensorFile(await readBytes(path)), isotropic);
    stored.value = [...stored.value, { name, bottom, coats: [], solo: null }];
  }
});

/** Read what lies beside the page, once; returns whether it is read. What is wrong is told. */
export async function readStored(): Promise<boolean> {
  try {
    await readAll();
    return true;
  } catch (error) {
    complain(error, () => void readStored());
    return false;
  }
}

/** What a slot shows of a material; null if its texture was not opened. */
export function shownOf(material: MaterialCards): Shown | null {
  const { bottom, rotation = 0 } = material;
  if (bottom.kind !== "texels") {
    const stack = stackOf(material);
    return { stack, rotation, texture: null, table: tableOf(material, stack) };
  }
  const texture = textures.get(bottom.texture);
  if (texture === undefined) {
    complain(new Refusal(lost(`texture of “${material.name}”`)));
    return null;
  }
  const mean = { kind: "codes", latents: meanCodes(texture.texture) } as const;
  return { stack: { bottom: mean, coats: [] }, rotation: 0, texture };
}

/** The table by which a material is shown: that of its bottom if that is bare. */
function tableOf({ bottom, name }: MaterialCards, { coats }: Stack): FTable | undefined {
  if (bottom.kind !== "codes" || bottom.table === undefined || coats.length > 0) return undefined;
  const { table, besideLobe = false } = bottom;
  const logs = tables.get(table);
  if (logs !== undefined) return { logs, besideLobe };
  void readStored().then((isRead) => {
    if (isRead && tables.get(table) === undefined)
      complain(new Refusal(`${lost(`table of “${name}”`)} It is shown by its codes.`));
  });
  return undefined;
}
