/** What was opened and is no part of the state, which names it: as long as the page lives. */

import { signal } from "@preact/signals";
import { CHANNELS } from "../core/channels";
import { TABLE_SIZE } from "../core/f_table";
import { fromHalf, toHalf } from "../core/half";
import type { Occlusion } from "../core/occlusion";
import { TensorFile } from "../core/safetensors";
import { type CodeTexture, readTexture } from "../material/texture";
import { groundSize, type Mesh, meshOf, VERTEX_NUMBERS } from "../picture/meshes";
import type { LitPanorama } from "../picture/panorama";
import { Refusal } from "../refusal";
import { readTemplate, texelShaderText } from "../save/shader";
import { nameOf } from "../save/zip";
import { text } from "../state/json";
import type { State } from "../state/state";
import { change, state } from "../state/store";
import { byOwnWorker, once, type PageCore } from "./remote";

/** Things by their names, whose readers follow changes. */
class Kept<Thing> {
  private readonly all = signal<ReadonlyMap<string, Thing>>(new Map());

  get(name: string): Thing | undefined {
    return this.all.value.get(name);
  }

  /** One of the same name takes the other's place. */
  keep(name: string, thing: Thing): string {
    this.all.value = new Map(this.all.peek()).set(name, thing);
    return name;
  }
}

/** A texture and the shader code that makes materials of its texels. */
export interface ShownTexture {
  texture: CodeTexture;
  shader: string;
  /** The texels of the basis, which the shader code reads. */
  basis: Float32Array;
}

/** A panorama that was opened, and its file. */
interface OwnEnvironment extends LitPanorama {
  file: File;
}

/** By their check sums: textures of codes, and logarithms of f as of `FTable`. */
export const textures = new Kept<ShownTexture>();
export const tables = new Kept<Float32Array>();

/** By the names of their files. */
const meshes = new Kept<Mesh>();
const panoramas = new Kept<OwnEnvironment>();

/** The sentence on what is missing. */
export function lost(what: string): string {
  return `The ${what} is no part of the address or the state; open its file again.`;
}

/**
 * Keep the texture of a file; returns its name in the state.
 *
 * @throws Refusal if it is damaged or of other networks.
 */
export async function keepTexture(
  file: Uint8Array<ArrayBuffer>,
  core: Pick<PageCore, "latentSize" | "fingerprint" | "basisTexels">,
): Promise<string> {
  const texture = readTexture(new TensorFile(file), file, core);
  const shader = texelShaderText(await readTemplate("glsl"), texture);
  return textures.keep(texture.id, { texture, shader, basis: await core.basisTexels() });
}

/** Keep a table; returns its name in the state. */
export function keepTable(logs: Float32Array): string {
  return tables.keep(nameOf(halfBytes(logs)), logs);
}

/** The bytes of numbers in half precision. */
export function halfBytes(numbers: Float32Array): Uint8Array<ArrayBuffer> {
  return new Uint8Array(Uint16Array.from(numbers, toHalf).buffer);
}

/**
 * The logarithms of a table's bytes, half numbers of one channel or three.
 *
 * @throws Refusal if they are damaged.
 */
export function logsOfBytes(bytes: Uint8Array<ArrayBuffer>): Float32Array {
  const repeated = (2 * TABLE_SIZE) / bytes.length;
  const bits = new Uint16Array(bytes.buffer);
  const logs = Float32Array.from({ length: TABLE_SIZE }, (_, at) =>
    fromHalf(bits[Math.floor(at / repeated)]),
  );
  if ((repeated !== 1 && repeated !== CHANNELS) || !logs.every(Number.isFinite))
    throw new Refusal("The table of the material is damaged.");
  return logs;
}

/** The name of a file, as a state that is read has it. */
const fileLabel = text("file");

/** Show a mesh. */
export function useMesh(file: string, own: Mesh): void {
  change({ object: "own", mesh: meshes.keep(fileLabel(file), own) });
}

/** Light the object by a panorama. */
export function useEnvironment(file: string, own: OwnEnvironment): void {
  const name = panoramas.keep(fileLabel(file), own);
  const { environment, panorama } = state.peek();
  if (environment !== "own" || panorama !== name) change({ environment: "own", panorama: name });
}

/** The page's own meshes so far, which keep their occlusion. */
const built = new Map<string, Mesh>();

/** The mesh of a state's object; the goblet, and true, while the one that was opened is missing. */
export function meshOfState({ object, mesh }: State): { mesh: Mesh; isMissing: boolean } {
  const own = object === "own" ? meshes.get(mesh) : undefined;
  if (own !== undefined) return { mesh: own, isMissing: false };
  const name = object === "own" ? "goblet" : object;
  const known = built.get(name) ?? meshOf(name);
  built.set(name, known);
  return { mesh: known, isMissing: object === "own" };
}

/** The panorama of a state; null if it has none, or it was not opened. */
export function panoramaOf({ environment, panorama }: State): OwnEnvironment | null {
  return environment === "own" ? (panoramas.get(panorama) ?? null) : null;
}

/** What is known of each mesh's occlusion; its worker has no networks. */
const occlusions = new WeakMap<Mesh, () => Promise<Occlusion>>();

export function occlusionOf(mesh: Mesh): Promise<Occlusion> {
  let known = occlusions.get(mesh);
  if (known === undefined) {
    const { vertices, faces } = mesh;
    const args = [vertices, VERTEX_NUMBERS, faces, groundSize(mesh)] as const;
    known = once(() => byOwnWorker("occlusion", [...args]));
    occlusions.set(mesh, known);
  }
  return known();
}
