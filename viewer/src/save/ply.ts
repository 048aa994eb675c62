/** Meshes as PLY files (Turk 1994), binary. */

import { type Mesh, VERTEX_NUMBERS } from "../picture/meshes";

/** The bytes of a PLY file with positions, normals and uv. */
export function plyFile({ vertices, faces }: Mesh): Uint8Array<ArrayBuffer> {
  const properties = ["x", "y", "z", "nx", "ny", "nz", "u", "v"].map(
    (name) => `property float ${name}`,
  );
  const header = [
    "ply",
    "format binary_little_endian 1.0",
    `element vertex ${vertices.length / VERTEX_NUMBERS}`,
    ...properties,
    `element face ${faces.length / 3}`,
    "property list uchar int vertex_indices",
    "end_header\n",
  ].join("\n");
  const text = new TextEncoder().encode(header);
  const bytes = new Uint8Array(text.length + 4 * vertices.length + (13 * faces.length) / 3);
  bytes.set(text);
  const view = new DataView(bytes.buffer);
  let at = text.length;
  for (const number of vertices) {
    view.setFloat32(at, number, true);
    at += 4;
  }
  for (let face = 0; face < faces.length; face += 3) {
    view.setUint8(at, 3);
    for (let corner = 0; corner < 3; corner++)
      view.setInt32(at + 1 + 4 * corner, faces[face + corner], true);
    at += 13;
  }
  return bytes;
}
