/** Textures of codes and tables of f that were opened: the page's state names them only. */

import { signal } from "@preact/signals";
import { CHANNELS } from "../core/channels";
import { TABLE_SIZE } from "../core/f_table";
import { fromHalf, toHalf } from "../core/half";
import { TensorFile } from "../core/safetensors";
import { type CodeTexture, readTexture } from "../material/texture";
import { Refusal } from "../refusal";
import { readTemplate, texelShaderText } from "../save/shader";
import { crc32 } from "../save/zip";
import type { PageCore } from "./remote";

/** A texture and the shader code that makes materials of its texels. */
export interface ShownTexture {
  texture: CodeTexture;
  shader: string;
  /** The texels of the basis, which the shader code reads. */
  basis: Float32Array;
}

export const textures = signal<ReadonlyMap<string, ShownTexture>>(new Map());

/**
 * Keep the texture of a file as long as the page lives; returns its name in the state.
 *
 * @throws Refusal if it is damaged or of other networks.
 */
export async function keepTexture(
  file: Uint8Array<ArrayBuffer>,
  core: Pick<PageCore, "latentSize" | "fingerprint" | "basisTexels">,
): Promise<string> {
  const texture = readTexture(new TensorFile(file), file, core);
  const shader = texelShaderText(await readTemplate("glsl"), texture);
  const shown = { texture, shader, basis: await core.basisTexels() };
  textures.value = new Map(textures.value).set(texture.id, shown);
  return texture.id;
}

/** Logarithms of f, as of `FTable`. */
export const tables = signal<ReadonlyMap<string, Float32Array>>(new Map());

/** Keep a table as long as the page lives; returns its name in the state, its check sum. */
export function keepTable(logs: Float32Array): string {
  const id = crc32(halfBytes(logs)).toString(16).padStart(8, "0");
  tables.value = new Map(tables.value).set(id, logs);
  return id;
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
  if (repeated !== 1 && repeated !== CHANNELS) throw damagedTable();
  const bits = new Uint16Array(bytes.buffer);
  const logs = Float32Array.from({ length: TABLE_SIZE }, (_, at) =>
    fromHalf(bits[Math.floor(at / repeated)]!),
  );
  if (!logs.every(Number.isFinite)) throw damagedTable();
  return logs;
}

function damagedTable(): Refusal {
  return new Refusal("The table of the material is damaged.");
}
