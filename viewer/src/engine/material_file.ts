/** Reading the files that `Material.save` writes. */

import type { Bottom } from "../core/api";
import { Refusal } from "../state/read";

interface Tensor {
  dtype: string;
  shape: number[];
  data_offsets: [number, number];
}

/**
 * The codes of a material file; a table in it is left out.
 *
 * @param latentSize numbers of one channel's code.
 * @throws Refusal if it is another file, damaged, or of other networks.
 */
export function readMaterialFile(bytes: Uint8Array, latentSize: number): Bottom {
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const length = bytes.length >= 8 ? view.getUint32(0, true) : 0;
  if (length === 0 || 8 + length > bytes.length) throw damaged();
  let header: Record<string, Tensor> & { __metadata__?: { urushi?: string } };
  let kind: unknown;
  try {
    header = JSON.parse(new TextDecoder().decode(bytes.subarray(8, 8 + length)));
    kind = JSON.parse(header.__metadata__?.urushi ?? "{}").kind;
  } catch {
    throw damaged();
  }
  if (kind !== "material") throw new Refusal("It is no material that Urushi has saved.");
  const codes = (name: string): Float32Array | null => {
    const tensor = header[name];
    if (tensor === undefined) return null;
    const [start, end] = tensor.data_offsets ?? [0, 0];
    const [rows, columns] = tensor.shape ?? [];
    if (tensor.dtype !== "F32" || (rows !== 3 && rows !== 1) || 8 + length + end > bytes.length)
      throw damaged();
    if (columns !== latentSize || end - start !== 4 * rows * columns)
      throw new Refusal("It was made with other networks; encode the material again.");
    const values = new Float32Array(bytes.slice(8 + length + start, 8 + length + end).buffer);
    if (!values.every(Number.isFinite)) throw damaged();
    return rows === 3 ? values : new Float32Array([...values, ...values, ...values]);
  };
  const latents = codes("latents");
  if (latents === null) throw damaged();
  return { kind: "codes", latents, anchors: codes("anchors") ?? latents };
}

function damaged(): Refusal {
  return new Refusal("It is damaged or no material that Urushi has saved.");
}
