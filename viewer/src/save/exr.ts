/** Pictures of radiance as OpenEXR files: single precision, not compressed. */

import type { Picture } from "../picture/panorama";

/** The bytes of an OpenEXR file ("OpenEXR File Layout", Academy Software Foundation). */
export function exrFile({ width, height, pixels }: Picture): Uint8Array<ArrayBuffer> {
  const header = headerOf(width, height);
  const table = 8 * height;
  const row = 8 + 12 * width;
  const start = header.length + table;
  const bytes = new Uint8Array(start + height * row);
  bytes.set(header);
  const view = new DataView(bytes.buffer);
  for (let y = 0; y < height; y++) {
    let at = start + y * row;
    view.setBigUint64(header.length + 8 * y, BigInt(at), true);
    view.setInt32(at, y, true);
    view.setInt32(at + 4, row - 8, true);
    at += 8;
    for (const place of [2, 1, 0]) // channels stand in alphabetical order
      for (let x = 0; x < width; x++, at += 4)
        view.setFloat32(at, pixels[3 * (y * width + x) + place], true);
  }
  return bytes;
}

function headerOf(width: number, height: number): Uint8Array {
  const text = (value: string) => [...new TextEncoder().encode(value), 0];
  const integers = (...values: number[]) => [...new Uint8Array(Int32Array.from(values).buffer)];
  const floats = (...values: number[]) => [...new Uint8Array(Float32Array.from(values).buffer)];
  const attribute = (name: string, kind: string, value: number[]) => [
    ...[...text(name), ...text(kind), ...integers(value.length)],
    ...value,
  ];
  // Single precision, linear, and sampling in x and y
  const channels = ["B", "G", "R"].flatMap((name) => [...text(name), ...integers(2, 0, 1, 1)]);
  const window = integers(0, 0, width - 1, height - 1);
  return Uint8Array.from([
    ...integers(20000630, 2), // the format's number, and its version
    ...attribute("channels", "chlist", [...channels, 0]),
    ...attribute("compression", "compression", [0]),
    ...attribute("dataWindow", "box2i", window),
    ...attribute("displayWindow", "box2i", window),
    ...attribute("lineOrder", "lineOrder", [0]),
    ...attribute("pixelAspectRatio", "float", floats(1)),
    ...attribute("screenWindowCenter", "v2f", floats(0, 0)),
    ...attribute("screenWindowWidth", "float", floats(1)),
    0,
  ]);
}
