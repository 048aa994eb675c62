/** The head of a safetensors file that Python has saved. */

export interface Tensor {
  dtype: string;
  shape: number[];
  data_offsets: [number, number];
}

export type Fields = Record<string, unknown>;

/** What the head says, and where the numbers begin; null: it is no safetensors file. */
export function headerOf(
  file: Uint8Array,
): { description: Fields; tensors: Record<string, Tensor | undefined>; start: number } | null {
  if (file.length < 8) return null;
  const view = new DataView(file.buffer, file.byteOffset, file.byteLength);
  const length = Number(view.getBigUint64(0, true));
  if (length === 0 || 8 + length > file.length) return null;
  try {
    const tensors = JSON.parse(new TextDecoder().decode(file.subarray(8, 8 + length)));
    const description = Object(JSON.parse(tensors.__metadata__?.urushi ?? "{}")) as Fields;
    return { description, tensors, start: 8 + length };
  } catch {
    return null;
  }
}
