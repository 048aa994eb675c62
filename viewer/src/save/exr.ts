/** Pictures of radiance as OpenEXR files: single precision, not compressed. */

/** A picture (height, width, 3) of linear radiance, the first row at the top. */
export interface Radiance {
  width: number;
  height: number;
  pixels: Float32Array;
}

/** Channels of a file stand in alphabetical order; the numbers are their places in a pixel. */
const CHANNELS = [
  ["B", 2],
  ["G", 1],
  ["R", 0],
] as const;

const MAGIC = 20000630;
const VERSION = 2;
const FLOAT = 2;

/** The bytes of an OpenEXR file ("OpenEXR File Layout", Academy Software Foundation). */
export function exrFile({ width, height, pixels }: Radiance): Uint8Array<ArrayBuffer> {
  const header = headerOf(width, height);
  const table = 8 * height;
  const row = 8 + CHANNELS.length * 4 * width;
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
    for (const [, place] of CHANNELS)
      for (let x = 0; x < width; x++, at += 4)
        view.setFloat32(at, pixels[3 * (y * width + x) + place]!, true);
  }
  return bytes;
}

function headerOf(width: number, height: number): Uint8Array {
  const channels = CHANNELS.flatMap(([name]) => [
    ...text(name),
    ...integers(FLOAT, 0, 1, 1), // kind, linear, and sampling in x and y
  ]);
  const window = integers(0, 0, width - 1, height - 1);
  const attributes: [string, string, number[]][] = [
    ["channels", "chlist", [...channels, 0]],
    ["compression", "compression", [0]],
    ["dataWindow", "box2i", window],
    ["displayWindow", "box2i", window],
    ["lineOrder", "lineOrder", [0]],
    ["pixelAspectRatio", "float", floats(1)],
    ["screenWindowCenter", "v2f", floats(0, 0)],
    ["screenWindowWidth", "float", floats(1)],
  ];
  return Uint8Array.from([
    ...integers(MAGIC, VERSION),
    ...attributes.flatMap(([name, kind, value]) => [
      ...text(name),
      ...text(kind),
      ...integers(value.length),
      ...value,
    ]),
    0,
  ]);
}

function text(value: string): number[] {
  return [...new TextEncoder().encode(value), 0];
}

function integers(...values: number[]): number[] {
  return [...new Uint8Array(Int32Array.from(values).buffer)];
}

function floats(...values: number[]): number[] {
  return [...new Uint8Array(Float32Array.from(values).buffer)];
}
