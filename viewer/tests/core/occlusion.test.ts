import { expect, test } from "vitest";
import { axesOf, GROUND_SIDE, occlusion } from "../../src/core/occlusion";

type Vector = [number, number, number];

/** A grid of a surface with its normals, as (vertices of six numbers, faces). */
function grid(steps: number, at: (u: number, v: number) => [place: Vector, normal: Vector]) {
  const vertices: number[] = [];
  const faces: number[] = [];
  for (let row = 0; row <= steps; row++)
    for (let column = 0; column <= steps; column++) {
      for (const part of at(column / steps, row / steps)) vertices.push(...part);
      if (row === steps || column === steps) continue;
      const first = row * (steps + 1) + column;
      const above = first + steps + 1;
      faces.push(first, first + 1, above + 1, first, above + 1, above);
    }
  return { vertices, faces };
}

/** A part of a unit sphere from the south pole to a height, seen from outside (1) or inside (-1). */
function sphere(top: number, side: 1 | -1) {
  return grid(64, (u, v) => {
    const z = v * (top + 1) - 1;
    const r = Math.sqrt(Math.max(1 - z * z, 0));
    const place: Vector = [r * Math.cos(2 * Math.PI * u), r * Math.sin(2 * Math.PI * u), z];
    return [place, place.map((part) => side * part) as Vector];
  });
}

function all({ vertices, faces }: { vertices: number[]; faces: number[] }) {
  return occlusion(new Float32Array(vertices), 6, new Uint32Array(faces), 4);
}

const of = (mesh: Parameters<typeof all>[0]) => all(mesh).openings;

test("nothing of a ball hides its light: all is open, along the normal", () => {
  const mesh = sphere(1, 1);
  const found = of(mesh);
  for (let i = 0; i < found.length / 4; i++) {
    expect(found[4 * i + 3]).toBe(1);
    for (let k = 0; k < 3; k++)
      expect(found[4 * i + k]).toBeCloseTo(mesh.vertices[6 * i + 3 + k], 5);
  }
});

test("everywhere in a hollow cap of a sphere, the opening has its share of the sphere's area", () => {
  // Of the light that leaves a point in a sphere by the cosine, equal areas get equal parts.
  for (const top of [-0.5, 0, 0.5]) {
    const found = of(sphere(top, -1));
    const share = (1 - top) / 2;
    // Not at the rim; the directions resolve a few percent.
    for (let i = 0; i < 65 * 56; i++) expect(Math.abs(found[4 * i + 3] - share)).toBeLessThan(0.04);
    for (let i = 0; i < 65; i++) expect(found[4 * i + 2]).toBeGreaterThan(0.995); // at the pole
  }
});

test("beside a high wall half of the light arrives, from the quarter of the sphere before it", () => {
  const floor = grid(64, (u, v) => [
    [u, 2 * v - 1, 0],
    [0, 0, 1],
  ]);
  const wall = grid(1, (u, v) => [
    [0, 8 * u - 4, 4 * v],
    [1, 0, 0],
  ]);
  const first = floor.vertices.length / 6;
  const found = of({
    vertices: [...floor.vertices, ...wall.vertices],
    faces: [...floor.faces, ...wall.faces.map((vertex) => first + vertex)],
  });
  // The mean of the quarter's directions by their cosines is (2/3, 0, pi/3), not yet of unit length.
  const length = Math.hypot(2 / 3, Math.PI / 3);
  const at = 4 * (65 * 32 + 8); // an eighth from the wall, which is 32 times as high
  const [x, y, z, open] = found.subarray(at, at + 4);
  expect(Math.abs(open! - 0.5)).toBeLessThan(0.03);
  expect(Math.abs(x! - 2 / 3 / length)).toBeLessThan(0.03);
  expect(Math.abs(y!)).toBeLessThan(0.03);
  expect(Math.abs(z! - Math.PI / 3 / length)).toBeLessThan(0.03);
});

test("a ball's shadow is as large as the ground that a cylinder of light cuts, away from the light", () => {
  const { shadows } = all(sphere(1, 1)); // about the origin: half of it lies under the ground
  const axes = axesOf(shadows);
  for (let axis = axes >> 1; axis < axes; axis += 16) {
    const z = (axis + 0.5) / axes; // of the direction to the light, along the spiral of axes
    const shadow = shadows.subarray(axis * GROUND_SIDE ** 2, (axis + 1) * GROUND_SIDE ** 2);
    const area = shadow.filter((texel) => texel > 0).length * (8 / GROUND_SIDE) ** 2;
    expect(Math.abs((area * z) / Math.PI - 1)).toBeLessThan(0.04); // of texels, of either kind
  }
});

test("a pole's shadow lies opposite to the light", () => {
  const pole = grid(8, (u, v) => [
    [0.05 * Math.cos(2 * Math.PI * u), 0.05 * Math.sin(2 * Math.PI * u), 2 * v],
    [Math.cos(2 * Math.PI * u), Math.sin(2 * Math.PI * u), 0],
  ]);
  const { shadows } = all(pole);
  const axes = axesOf(shadows);
  for (const axis of [axes >> 1, (axes >> 1) + 1, (axes >> 1) + 2]) {
    const z = (axis + 0.5) / axes;
    const phi = axis * Math.PI * (3 - Math.sqrt(5));
    let [x, y, count] = [0, 0, 0];
    shadows
      .subarray(axis * GROUND_SIDE ** 2, (axis + 1) * GROUND_SIDE ** 2)
      .forEach((texel, at) => {
        if (texel === 0) return;
        x += (((at % GROUND_SIDE) + 0.5) / GROUND_SIDE) * 8 - 4;
        y += ((Math.floor(at / GROUND_SIDE) + 0.5) / GROUND_SIDE) * 8 - 4;
        count++;
      });
    // Its middle is that of the shadow of the pole's middle, at height 1.
    const away = Math.sqrt(1 - z * z) / z;
    expect(Math.abs(x / count + away * Math.cos(phi))).toBeLessThan(0.08);
    expect(Math.abs(y / count + away * Math.sin(phi))).toBeLessThan(0.08);
  }
});
