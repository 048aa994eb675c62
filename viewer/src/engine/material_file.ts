/** Material files: those that `Material.save` of Python writes and `urushi.load` reads. */

import type { Material } from "../core/api";
import { CHANNELS } from "../core/channels";
import type { Networks } from "../core/core";
import { type Tensor, type TensorFile, tensorFile } from "../core/safetensors";
import type { CodesBottom } from "../material/material";
import { wrapped } from "../material/parameters";
import { TABLE } from "../printed/formulas";
import { Refusal } from "../refusal";
import { halfBytes, keepTable, logsOfBytes } from "./opened";

/** Version of the format. */
const VERSION = 3;

/**
 * The codes and the rotation of a material file; a table in it is kept as long as the page lives.
 *
 * @throws Refusal if it is another file, damaged, or of other networks.
 */
export function readMaterialFile(
  file: TensorFile,
  { latentSize, widths, fingerprint }: Networks,
): { bottom: CodesBottom; rotation?: number } {
  const { kind, weights, beside_lobe, rotation = 0 } = file.description;
  if (kind !== "material") throw new Refusal("It is no material that Urushi has saved.");
  if (weights !== fingerprint)
    throw new Refusal("It was made with other networks; encode the material again.");
  const [channels = 0] = file.shapeOf("latents");
  const codes = file.numbers("latents", [channels === 1 ? 1 : CHANNELS, latentSize]);
  const latents = Float32Array.from(channels === 1 ? [...codes, ...codes, ...codes] : codes);
  const bottom = { kind: "codes", latents } as const;
  if (widths === 1) {
    const shape = file.shapeOf("table");
    if (shape.length === 0) return { bottom };
    const table = keepTable(logsOfBytes(file.bytes("table", "F16", shape)));
    return { bottom: { ...bottom, table, besideLobe: beside_lobe === true } };
  }
  if (typeof rotation !== "number" || !Number.isFinite(rotation))
    throw new Refusal("The material's rotation is damaged.");
  return { bottom: { ...bottom, widths }, rotation: wrapped(rotation) };
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
  const codes = new Uint8Array(latents.slice().buffer);
  const arrays: Record<string, Tensor> = {
    latents: { dtype: "F32", shape: [CHANNELS, latentSize], bytes: codes },
  };
  if (table !== undefined) {
    const shape = [...TABLE.SHAPE, CHANNELS];
    arrays.table = { dtype: "F16", shape, bytes: halfBytes(table.logs) };
  }
  return tensorFile(description, arrays);
}
