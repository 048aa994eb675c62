/** Meshes of files: a box as OBJ and as glTF is the same box, and what is wrong is told. */

import { expect, test } from "vitest";
import { readMesh } from "../../src/picture/mesh_files";
import { VERTEX_NUMBERS } from "../../src/picture/meshes";

/** The corners of a box of 2 by 6 by 4, y upwards, and its six sides, outwards. */
const CORNERS = Array.from({ length: 8 }, (_, k) => [k & 1 ? 2 : 0, k & 2 ? 6 : 0, k & 4 ? 4 : 0]);
const SIDES = [
  [0, 4, 6, 2],
  [1, 3, 7, 5],
  [0, 1, 5, 4],
  [2, 6, 7, 3],
  [0, 2, 3, 1],
  [4, 5, 7, 6],
];
const POINTS = SIDES.flat().map((corner) => CORNERS[corner]);
const FANS = SIDES.flatMap((_, k) => [0, 1, 2, 0, 2, 3].map((corner) => 4 * k + corner));

const text = (value: string) => new TextEncoder().encode(value);
const NORMALS = ["-1 0 0", "1 0 0", "0 -1 0", "0 1 0", "0 0 -1", "0 0 1"];
const OBJ = [
  ...CORNERS.map((point) => `v ${point.join(" ")}`),
  ...NORMALS.map((normal) => `vn ${normal}`),
  ...SIDES.map((side, k) => `f ${side.map((corner) => `${corner + 1}//${k + 1}`).join(" ")}`),
].join("\n");

/** A .glb; node: its transformation. */
function glb(node: object, extra: object = {}, corners = FANS.length): Uint8Array<ArrayBuffer> {
  const binary = new Uint8Array(4 * 3 * POINTS.length + 2 * FANS.length);
  binary.set(new Uint8Array(Float32Array.from(POINTS.flat()).buffer));
  binary.set(new Uint8Array(Uint16Array.from(FANS).buffer), 4 * 3 * POINTS.length);
  const json = JSON.stringify({
    ...extra,
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes: [{ children: [1] }, { mesh: 0, ...node }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: POINTS.length, type: "VEC3" },
      { bufferView: 1, componentType: 5123, count: corners, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteLength: 4 * 3 * POINTS.length },
      { buffer: 0, byteOffset: 4 * 3 * POINTS.length, byteLength: 2 * FANS.length },
    ],
    buffers: [{ byteLength: binary.length }],
  });
  const padded = text(json.padEnd(Math.ceil(json.length / 4) * 4));
  const bytes = new Uint8Array(28 + padded.length + binary.length);
  const view = new DataView(bytes.buffer);
  const head = [0x46546c67, 2, bytes.length, padded.length, 0x4e4f534a];
  head.forEach((number, k) => {
    view.setUint32(4 * k, number, true);
  });
  view.setUint32(20 + padded.length, binary.length, true);
  view.setUint32(24 + padded.length, 0x4e4942, true);
  bytes.set(padded, 20);
  bytes.set(binary, 28 + padded.length);
  return bytes;
}

const box = await readMesh(text(OBJ), "obj");

test("a box stands upright on the ground, about the axis", () => {
  expect(box.faces.length).toBe(36);
  expect(box.centre[0]).toBeCloseTo(0, 6);
  expect(box.centre[1]).toBeCloseTo(0, 6);
  expect(box.centre[2]).toBeCloseTo(box.halfHeight, 6);
  expect(box.radius).toBeCloseTo(0.7, 6);
  expect(box.halfHeight / box.radius).toBeCloseTo(3 / Math.hypot(1, 2, 3), 6);
});

test("its normals point outwards, its tangents lie in the surface", () => {
  for (let vertex = 0; vertex < POINTS.length; vertex++) {
    const at = VERTEX_NUMBERS * vertex;
    const [x, y, z, ...normal] = box.vertices.subarray(at, at + 6);
    const tangent = box.tangents.subarray(3 * vertex, 3 * vertex + 3);
    const dot = (a: ArrayLike<number>) => normal.reduce((sum, part, k) => sum + part * a[k], 0);
    expect(dot([x!, y!, z! - box.halfHeight])).toBeGreaterThan(0);
    expect(dot(normal)).toBeCloseTo(1, 5);
    expect(dot(tangent)).toBeCloseTo(0, 5);
    expect(Math.hypot(...tangent)).toBeCloseTo(1, 5);
  }
});

test.each([
  {},
  { translation: [3, 4, 5], scale: [2, 2, 2] },
  { scale: [-1, 1, 1] }, // a mirrored box is a box
  { rotation: [0, 1, 0, 0] }, // and so is one that is turned by half a turn
])("as glTF it is the same box: %j", async (node) => {
  const other = await readMesh(glb(node), "glb");
  const sorted = ({ vertices }: typeof box) =>
    Array.from({ length: POINTS.length }, (_, k) =>
      [...vertices.subarray(VERTEX_NUMBERS * k, VERTEX_NUMBERS * k + 6)]
        .map((x) => (Math.abs(x) < 1e-5 ? 0 : x).toFixed(4))
        .join(),
    ).sort();
  expect(sorted(other)).toEqual(sorted(box));
});

test("the data of a glTF may lie inside", async () => {
  const whole = glb({});
  const length = new DataView(whole.buffer).getUint32(12, true);
  const json = JSON.parse(new TextDecoder().decode(whole.subarray(20, 20 + length)));
  const data = Buffer.from(whole.subarray(28 + length)).toString("base64");
  json.buffers[0].uri = `data:application/octet-stream;base64,${data}`;
  expect(await readMesh(text(JSON.stringify(json)), "gltf")).toEqual(await readMesh(whole, "glb"));
});

test("corners may count from the end, and without normals get smooth ones", async () => {
  const triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  const one = await readMesh(text(`${triangle}f 1 2 3`), "obj");
  expect(await readMesh(text(`${triangle}f -3 -2 -1\r\n`), "obj")).toEqual(one);
  const given = `${triangle}vn 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1//1 2//1 3//1`;
  expect(await readMesh(text(given), "obj")).toEqual(one);
});

test.each([
  ["obj", text("f 1 2 3"), /damaged/],
  ["obj", text("v 0 0 0"), /no triangles/],
  ["glb", glb({}).slice(0, -8), /damaged/],
  ["glb", glb({}, { extensionsRequired: ["KHR_draco_mesh_compression"] }), /needs KHR_draco/],
  ["glb", glb({}, {}, 7_500_000), /more than a million/], // its numbers are not even there
  [
    "gltf",
    text('{"asset": {"version": "2.0"}, "buffers": [{"uri": "box.bin"}]}'),
    /another file.*\.glb/,
  ],
  ["gltf", text("glTF"), /damaged/],
])("a file that cannot be read is told: %s", async (suffix, bytes, told) => {
  await expect(readMesh(bytes, suffix)).rejects.toThrow(told);
});
