import { expect, test } from "vitest";
import { meshOf } from "../../src/picture/meshes";
import { plyFile } from "../../src/save/ply";
import { type Scene, sceneXml } from "../../src/save/scene";
import { crc32 } from "../../src/save/zip";
import { INITIAL } from "../../src/state/state";

test("the check sum has its published check value", () => {
  expect(crc32(new TextEncoder().encode("123456789"))).toBe(0xcbf43926);
});

test("a mesh file has a row for each vertex and face", () => {
  const mesh = meshOf("ball");
  const bytes = plyFile(mesh);
  const text = new TextDecoder("latin1").decode(bytes);
  const start = text.indexOf("end_header\n") + 11;
  expect(bytes.length - start).toBe(4 * mesh.vertices.length + (13 * mesh.faces.length) / 3);
  const view = new DataView(bytes.buffer);
  expect(view.getFloat32(start, true)).toBe(mesh.vertices[0]);
  expect(view.getInt32(bytes.length - 4, true)).toBe(mesh.faces.at(-1));
});

test("a scene's bright lights turn with the environment", () => {
  const scene: Scene = {
    mesh: meshOf("ball"),
    view: INITIAL.view,
    rotation: 30,
    width: 64,
    height: 32,
    environment: { suffix: "exr", bytes: new Uint8Array() },
    lights: [{ direction: [0, 0, 1], power: [1, 2, 3] }],
    material: new Uint8Array(),
  };
  const text = sceneXml(scene);
  expect(text.match(/<rotate z="1" angle="30"\/>/g)).toHaveLength(2);
  expect(text).toContain('value="1, 2, 3"');
  expect(text).toContain('target="0, 0, -1"');
  expect(text.replace(/\s+/g, " ")).toContain('filename" value="environment.exr"');
});
