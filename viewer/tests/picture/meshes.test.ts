import { expect, test } from "vitest";
import { cameraOf } from "../../src/picture/camera";
import { type Mesh, meshOf, VERTEX_NUMBERS } from "../../src/picture/meshes";
import { INITIAL, OBJECTS } from "../../src/state/state";

function vertex(mesh: Mesh, face: number, corner: number): number[] {
  const at = VERTEX_NUMBERS * mesh.faces[3 * face + corner]!;
  return [...mesh.vertices.subarray(at, at + 6)];
}

test.each(OBJECTS)("%s: faces are seen from outside, as the normals say", (name) => {
  const mesh = meshOf(name);
  let agreeing = 0;
  let seen = 0;
  for (let face = 0; face < mesh.faces.length / 3; face++) {
    const [a, b, c] = [0, 1, 2].map((corner) => vertex(mesh, face, corner)) as number[][];
    const [u, v] = [b!, c!].map((point) => [0, 1, 2].map((k) => point[k]! - a![k]!)) as number[][];
    const normal = [
      u![1]! * v![2]! - u![2]! * v![1]!,
      u![2]! * v![0]! - u![0]! * v![2]!,
      u![0]! * v![1]! - u![1]! * v![0]!,
    ];
    if (Math.hypot(...normal) < 1e-9) continue; // at a pole
    seen++;
    if (normal.reduce((sum, part, k) => sum + part * a![3 + k]!, 0) > 0) agreeing++;
  }
  expect(agreeing / seen).toBeGreaterThan(0.995);
});

test.each(OBJECTS)("%s: normals are unit vectors, and the ball around it holds it", (name) => {
  const mesh = meshOf(name);
  let [farthest, deviation] = [0, 0];
  for (let at = 0; at < mesh.vertices.length; at += VERTEX_NUMBERS) {
    const [x, y, z, ...normal] = mesh.vertices.subarray(at, at + 6);
    deviation = Math.max(deviation, Math.abs(Math.hypot(...normal) - 1));
    const away = Math.hypot(x! - mesh.centre[0], y! - mesh.centre[1], z! - mesh.centre[2]);
    farthest = Math.max(farthest, away);
  }
  expect(deviation).toBeLessThan(1e-5);
  expect(farthest).toBeCloseTo(mesh.radius, 5);
});

test.each(OBJECTS)("%s: tangents are unit vectors in the surface", (name) => {
  const { vertices, tangents } = meshOf(name);
  let [deviation, slant] = [0, 0];
  for (let i = 0; i < tangents.length / 3; i++) {
    const tangent = tangents.subarray(3 * i, 3 * i + 3);
    const normal = vertices.subarray(VERTEX_NUMBERS * i + 3, VERTEX_NUMBERS * i + 6);
    deviation = Math.max(deviation, Math.abs(Math.hypot(...tangent) - 1));
    slant = Math.max(slant, Math.abs(tangent.reduce((sum, x, k) => sum + x * normal[k]!, 0)));
  }
  expect(deviation).toBeLessThan(1e-5);
  expect(slant).toBeLessThan(1e-4);
});

test("tangents go round the bowl's axis, and along the sheet", () => {
  const bowl = meshOf("bowl");
  for (let i = 0; i < bowl.tangents.length / 3; i++) {
    const [x, y] = bowl.vertices.subarray(VERTEX_NUMBERS * i, VERTEX_NUMBERS * i + 2);
    const [u, v, w] = bowl.tangents.subarray(3 * i, 3 * i + 3);
    expect(Math.abs(x! * u! + y! * v!) + Math.abs(w!)).toBeLessThan(1e-4);
  }
  const sheet = meshOf("sheet");
  for (let i = 0; i < sheet.tangents.length / 3; i++)
    expect(sheet.tangents[3 * i]).toBeGreaterThanOrEqual(0);
});

test("the ball is round", () => {
  const { vertices } = meshOf("ball");
  let deviation = 0;
  for (let at = 0; at < vertices.length; at += VERTEX_NUMBERS) {
    const outwards = [vertices[at]!, vertices[at + 1]!, vertices[at + 2]! - 1];
    const away = outwards.map((part, k) => Math.abs(vertices[at + 3 + k]! - part));
    deviation = Math.max(deviation, ...away);
  }
  expect(deviation).toBeLessThan(0.01);
});

function projected(matrix: number[], point: readonly number[]): number[] {
  const [x, y, z, w] = [0, 1, 2, 3].map((row) =>
    [...point, 1].reduce((sum, part, column) => sum + matrix[4 * column + row]! * part, 0),
  ) as [number, number, number, number];
  return [x / w, y / w, z / w];
}

test.each([
  [1.6, 30, 20, 24],
  [0.5, -140, 70, 24],
  [1.6, 30, 20, 5],
  [1.6, 30, 20, 60],
])("at aspect %d the camera has the whole object in the picture", (...place) => {
  const [aspect, azimuth, elevation, fov] = place;
  const mesh = meshOf("teapot");
  const camera = cameraOf(mesh, { azimuth, elevation, zoom: 1, fov, pan: [0, 0] }, aspect);
  const middle = projected(camera.projection, mesh.centre);
  expect(middle[0]).toBeCloseTo(0, 6);
  let farthest = 0;
  for (let at = 0; at < mesh.vertices.length; at += 10 * VERTEX_NUMBERS) {
    const point = projected(camera.projection, [...mesh.vertices.subarray(at, at + 3)]);
    farthest = Math.max(farthest, ...point.map(Math.abs));
  }
  expect(farthest).toBeLessThan(1);
});

test("a shift moves the picture by parts of it", () => {
  const mesh = meshOf("ball");
  const view = { ...INITIAL.view, azimuth: 0, elevation: 0 };
  const still = projected(cameraOf(mesh, view, 1).projection, [0.3, 0.2, 1.4]);
  const moved = projected(cameraOf(mesh, view, 1, [0.01, -0.02]).projection, [0.3, 0.2, 1.4]);
  expect(moved[0]! - still[0]!).toBeCloseTo(0.01, 6);
  expect(moved[1]! - still[1]!).toBeCloseTo(-0.02, 6);
});

test("the field of view is the angle of the picture's height where the ball around the object fills 80 %", () => {
  const mesh = meshOf("ball");
  for (const fov of [5, 24, 60]) {
    const { eye } = cameraOf(mesh, { ...INITIAL.view, fov }, 1);
    const distance = Math.hypot(...eye.map((x, k) => x - mesh.centre[k]!));
    const height = 2 * distance * Math.tan((fov * Math.PI) / 360);
    expect((2 * mesh.radius) / height).toBeCloseTo(0.8, 9);
  }
});

test("a pan shifts the object by half heights of the picture, and a zoom enlarges the shift", () => {
  const mesh = meshOf("goblet");
  for (const [zoom, aspect] of [
    [1, 1.6],
    [2, 0.7],
  ] as const) {
    const view = { ...INITIAL.view, zoom, pan: [0.3, -0.2] as const };
    const middle = projected(cameraOf(mesh, view, aspect).projection, mesh.centre);
    expect(middle[0]).toBeCloseTo((0.3 * zoom) / aspect, 6);
    expect(middle[1]).toBeCloseTo(-0.2 * zoom, 6);
  }
});
