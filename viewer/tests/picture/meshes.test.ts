import { expect, test } from "vitest";
import { cameraOf } from "../../src/picture/camera";
import { meshOf, VERTEX_NUMBERS } from "../../src/picture/meshes";
import { cross, dot, minus, type Vector } from "../../src/picture/vectors";
import { INITIAL, OBJECTS } from "../../src/state/state";

const at = (numbers: Float32Array, vertex: number, width: number, first = 0) =>
  numbers.subarray(
    width * vertex + first,
    width * vertex + first + 3,
  ) as ArrayLike<number> as Vector;

test.each(OBJECTS)("%s: unit normals, outwards, unit tangents across, in a ball", (name) => {
  const { vertices, tangents, faces, centre, radius } = meshOf(name);
  let [length, slant, farthest] = [0, 0, 0];
  for (let i = 0; i < tangents.length / 3; i++) {
    const normal = at(vertices, i, VERTEX_NUMBERS, 3);
    const tangent = at(tangents, i, 3);
    for (const way of [normal, tangent]) length = Math.max(length, Math.abs(dot(way, way) - 1));
    slant = Math.max(slant, Math.abs(dot(normal, tangent)));
    farthest = Math.max(farthest, Math.hypot(...minus(at(vertices, i, VERTEX_NUMBERS), centre)));
  }
  expect(length).toBeLessThan(2e-5);
  expect(slant).toBeLessThan(1e-4);
  expect(farthest).toBeCloseTo(radius, 5);
  let [agreeing, seen] = [0, 0];
  for (let face = 0; face < faces.length; face += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => at(vertices, faces[face + k], VERTEX_NUMBERS));
    const outwards = cross(minus(b!, a!), minus(c!, a!));
    if (Math.hypot(...outwards) < 1e-9) continue; // at a pole
    seen++;
    agreeing += Number(dot(outwards, at(vertices, faces[face], VERTEX_NUMBERS, 3)) > 0);
  }
  expect(agreeing / seen).toBeGreaterThan(0.995);
});

test("tangents go round the bowl's axis, and along the sheet", () => {
  const bowl = meshOf("bowl");
  for (let i = 0; i < bowl.tangents.length / 3; i++) {
    const [x, y] = at(bowl.vertices, i, VERTEX_NUMBERS);
    const [u, v, w] = at(bowl.tangents, i, 3);
    expect(Math.abs(x * u + y * v) + Math.abs(w)).toBeLessThan(1e-4);
  }
  const sheet = meshOf("sheet");
  for (let i = 0; i < sheet.tangents.length / 3; i++)
    expect(sheet.tangents[3 * i]).toBeGreaterThanOrEqual(0);
});

test("the ball is round", () => {
  const { vertices } = meshOf("ball");
  for (let i = 0; i < vertices.length / VERTEX_NUMBERS; i++) {
    const outwards = minus(at(vertices, i, VERTEX_NUMBERS), [0, 0, 1]);
    expect(Math.hypot(...minus(at(vertices, i, VERTEX_NUMBERS, 3), outwards))).toBeLessThan(0.01);
  }
});

function projected(matrix: number[], point: readonly number[]): number[] {
  const [x, y, z, w] = [0, 1, 2, 3].map((row) =>
    [...point, 1].reduce((sum, part, column) => sum + matrix[4 * column + row] * part, 0),
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
  expect(moved[0] - still[0]).toBeCloseTo(0.01, 6);
  expect(moved[1] - still[1]).toBeCloseTo(-0.02, 6);
});

test("the field of view is the angle of the picture's height where the ball around the object fills 80 %", () => {
  const mesh = meshOf("ball");
  for (const fov of [5, 24, 60]) {
    const { eye } = cameraOf(mesh, { ...INITIAL.view, fov }, 1);
    const distance = Math.hypot(...eye.map((x, k) => x - mesh.centre[k]));
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
