/** Material files: those that `Material.save` of Python writes and `urushi.load` reads. */

import type { Material } from "../core/api";
import { CHANNELS } from "../core/channels";
import type { Networks } from "../core/core";
import { TABLE } from "../core/formulas";
import { headerOf } from "../core/safetensors";
import type { CodesBottom } from "../material/material";
import { Refusal } from "../refusal";
import { halfBits, keepTable, logsOfBits } from "./textures";

/** Version of the format. */
const VERSION = 3;

/** The fingerprint of the networks that a material file names. */
export function networksOf(bytes: Uint8Array): unknown {
  return materialHeader(bytes).description.weights;
}

/**
 * The codes and the rotation of a material file; a table in it is kept as long as the page lives.
 *
 * @throws Refusal if it is another file, damaged, or of other networks.
 */
export function readMaterialFile(
  bytes: Uint8Array,
  { latentSize, widths, fingerprint }: Networks,
): { bottom: CodesBottom; rotation?: number } {
  const { description, tensors, start: first } = materialHeader(bytes);
  if (description.weights !== fingerprint) throw foreign();
  const latentsOf = (): Float32Array => {
    const tensor = tensors.latents;
    if (tensor === undefined) throw damaged();
    const [start, end] = tensor.data_offsets ?? [0, 0];
    const [rows, columns] = tensor.shape ?? [];
    if (tensor.dtype !== "F32" || (rows !== 3 && rows !== 1) || first + end > bytes.length)
      throw damaged();
    if (columns !== latentSize || end - start !== 4 * rows * columns) throw damaged();
    const values = new Float32Array(bytes.slice(first + start, first + end).buffer);
    if (!values.every(Number.isFinite)) throw damaged();
    return rows === 3 ? values : new Float32Array([...values, ...values, ...values]);
  };
  const bottom = { kind: "codes", latents: latentsOf() } as const;
  if (widths === 1) {
    const { data_offsets: [start, end] = [0, 0], dtype } = tensors.table ?? {};
    if (start === end) return { bottom };
    if (dtype !== "F16" || first + end > bytes.length) throw damaged();
    const table = keepTable(logsOfBits(bytes.slice(first + start, first + end)));
    return { bottom: { ...bottom, table, besideLobe: description.beside_lobe === true } };
  }
  const { rotation = 0 } = description;
  if (typeof rotation !== "number" || !Number.isFinite(rotation)) throw damaged();
  return { bottom: { ...bottom, widths }, rotation: wrapped(rotation) };
}

function materialHeader(bytes: Uint8Array) {
  const header = headerOf(bytes);
  if (header === null) throw damaged();
  if (header.description.kind !== "material")
    throw new Refusal("It is no material that Urushi has saved.");
  return header;
}

/** An angle [degrees] in [-180, 180). */
function wrapped(angle: number): number {
  return ((((angle + 180) % 360) + 360) % 360) - 180;
}

/** The bytes of a material file; rotation: of the tangent [degrees]. */
export function materialFile(
  { latents, table: own }: Pick<Material, "latents"> & Partial<Material>,
  { latentSize, widths, fingerprint }: Networks,
  rotation = 0,
): Uint8Array<ArrayBuffer> {
  const table = own?.isOfCodes ? undefined : own;
  const turn = widths === 2 && rotation !== 0 ? { rotation } : {};
  const kind = table === undefined ? {} : { beside_lobe: table.besideLobe };
  const description = {
    kind: "material",
    version: VERSION,
    weights: fingerprint,
    ...turn,
    ...kind,
  };
  const codesEnd = latents.byteLength;
  const end = codesEnd + 2 * (table?.logs.length ?? 0);
  const header: Record<string, unknown> = {
    __metadata__: { urushi: JSON.stringify(description) },
    latents: { dtype: "F32", shape: [CHANNELS, latentSize], data_offsets: [0, codesEnd] },
  };
  if (table !== undefined) {
    const shape = [...TABLE.SHAPE, CHANNELS];
    header.table = { dtype: "F16", shape, data_offsets: [codesEnd, end] };
  }
  const json = JSON.stringify(header);
  // Numbers begin at a multiple of eight bytes.
  const text = new TextEncoder().encode(json.padEnd(Math.ceil(json.length / 8) * 8));
  const bytes = new Uint8Array(8 + text.length + end);
  const view = new DataView(bytes.buffer);
  view.setBigUint64(0, BigInt(text.length), true);
  bytes.set(text, 8);
  latents.forEach((number, k) => {
    view.setFloat32(8 + text.length + 4 * k, number, true);
  });
  if (table !== undefined)
    bytes.set(new Uint8Array(halfBits(table.logs).buffer), 8 + text.length + codesEnd);
  return bytes;
}

function foreign(): Refusal {
  return new Refusal("It was made with other networks; encode the material again.");
}

function damaged(): Refusal {
  return new Refusal("It is damaged or no material that Urushi has saved.");
}
