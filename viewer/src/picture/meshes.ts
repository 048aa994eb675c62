/** Triangle meshes of the objects: shapes turned on a lathe, and tubes. The axis is z. */

import { CADDY, TEAPOT } from "../printed/formulas";
import type { OBJECTS } from "../state/state";
import { BOWL, GOBLET, PLATE, type Point, VASE } from "./outlines";
import { cross, minus, unit, type Vector } from "./vectors";

/** A mesh that fits into a ball. */
export interface Mesh {
  /** Positions, unit normals and uv in [0, 1], `VERTEX_NUMBERS` a vertex. */
  vertices: Float32Array;
  /** Unit tangents, in the direction of growing u, three numbers a vertex. */
  tangents: Float32Array;
  faces: Uint32Array;
  /** Centre and radius of the ball. */
  centre: readonly [number, number, number];
  radius: number;
  /** Largest distance from the vertical axis through the centre, and half the height. */
  width: number;
  halfHeight: number;
}

/** Half the side of the square on the ground that can lie in a mesh's shadow. */
export function groundSize({ radius }: Mesh): number {
  return 3 * radius;
}

/** Numbers of a vertex. */
export const VERTEX_NUMBERS = 8;

/** A curve (radius, height) for places in [0, 1], from the foot to the top. */
type Outline = (place: number) => Point;

/** Points at u around and v along a surface, both in [0, 1]. */
type Surface = (u: number, v: number) => readonly [number, number, number];

const SHAPES: Record<(typeof OBJECTS)[number], () => Part[]> = {
  goblet: () => GOBLET.map((part) => turned(bezierOutline(part), 112, (part.length - 1) * 5)),
  ball: () => [turned(ballOutline, 96, 64)],
  caddy: () => [turned(splineOutline(CADDY.NATSUME), 96, 128)],
  plate: () => [turned(splineOutline(PLATE), 128, 96)],
  bowl: () => [turned(splineOutline(BOWL), 128, 128)],
  sheet: () => [pillow(96)],
  vase: () => [turned(splineOutline(VASE), 96, 128)],
  teapot: () => [
    turned(bezierOutline(TEAPOT.BODY), 96, 72),
    turned(bezierOutline(TEAPOT.LID), 72, 48),
    surface(tube(TEAPOT.HANDLE), 32, 60),
    surface(tube(TEAPOT.SPOUT), 32, 48),
  ],
};

/** The mesh of an object. */
export function meshOf(name: (typeof OBJECTS)[number]): Mesh {
  return joined(SHAPES[name]());
}

function ballOutline(place: number): Point {
  const angle = Math.PI * (place - 0.5);
  return [Math.cos(angle), 1 + Math.sin(angle)];
}

/** A uniform cubic B-spline whose ends lie on the axis, with horizontal tangents (de Boor 1978). */
function splineOutline(control: readonly Point[]): Outline {
  const last = control.length - 1;
  const mirrored = ([radius, height]: Point): Point => [-radius, height];
  const all = [mirrored(control[1]), ...control, mirrored(control[last - 1])];
  return (place) => {
    const t = place * last;
    const first = Math.min(Math.floor(t), last - 1);
    const s = t - first;
    const weights = [
      (1 - s) ** 3 / 6,
      (3 * s ** 3 - 6 * s ** 2 + 4) / 6,
      (-3 * s ** 3 + 3 * s ** 2 + 3 * s + 1) / 6,
      s ** 3 / 6,
    ];
    return weighted(weights, all.slice(first, first + 4));
  };
}

function bezierOutline(control: readonly Point[]): Outline {
  return (place) => weighted(...segmentAt(control, place));
}

/** Weights and control points at a place in [0, 1] of joined cubic Bézier segments of equal shares. */
function segmentAt<T>(control: readonly T[], place: number): [weights: number[], points: T[]] {
  const segments = (control.length - 1) / 3;
  const first = Math.min(Math.floor(place * segments), segments - 1);
  return [bernstein(place * segments - first), control.slice(3 * first, 3 * first + 4)];
}

function bernstein(t: number): number[] {
  const s = 1 - t;
  return [s ** 3, 3 * s ** 2 * t, 3 * s * t ** 2, t ** 3];
}

function weighted<T extends readonly number[]>(weights: number[], points: readonly T[]): T {
  const sum = (axis: number) => points.reduce((sum, point, k) => sum + weights[k] * point[axis], 0);
  return points[0].map((_, axis) => sum(axis)) as readonly number[] as T;
}

/** Rows along a tube, of four control points across its half with y <= 0. */
type Tube = readonly (readonly (readonly [number, number, number])[])[];

/** Height of the bottom of the teapot's body, above which its tubes are given. */
const BOTTOM = 0.15;

/** A closed tube of bicubic patches that is its own mirror image in y. */
function tube(control: Tube): Surface {
  return (u, v) => {
    const across = bernstein(u < 0.5 ? 2 * u : 2 - 2 * u);
    const [along, rows] = segmentAt(control, v);
    const [x, y, z] = weighted(
      along,
      rows.map((row) => weighted(across, row)),
    );
    return [x, u < 0.5 ? y : -y, z + BOTTOM];
  };
}

function turned(outline: Outline, around: number, along: number): Part {
  return surface(
    (u, v) => {
      const [radius, height] = outline(v);
      const angle = 2 * Math.PI * u;
      return [radius * Math.cos(angle), radius * Math.sin(angle), height];
    },
    around,
    along,
  );
}

/** Half the thickness of the sheet, and the exponents of its outline and of its rim. */
const THICKNESS = 0.09;
const CORNERS = 8;
const RIM = 6;

/**
 * A square sheet of metal with rounded corners and rims, slightly domed; u is along x everywhere, as
 * it was brushed.
 */
function pillow(steps: number): Part {
  const part = { vertices: [] as number[], tangents: [] as number[], faces: [] as number[] };
  for (const side of [1, -1]) {
    const first = part.vertices.length / VERTEX_NUMBERS;
    for (let row = 0; row <= steps; row++)
      for (let column = 0; column <= steps; column++) {
        const [x, y, inside] = squircle((2 * column) / steps - 1, (2 * row) / steps - 1);
        const height = THICKNESS * (1 - inside ** RIM) ** (1 / RIM) + 0.03 * (1 - inside * inside);
        // The gradient of the implicit surface, by differences of its own function
        const normal = unit(gradient(x, y, height));
        part.vertices.push(x, y, THICKNESS + side * height, normal[0], normal[1], side * normal[2]);
        part.vertices.push(0.5 + 0.5 * x, 0.5 + 0.5 * side * y);
        part.tangents.push(...alongX([normal[0], normal[1], side * normal[2]], side));
        if (row === steps || column === steps) continue;
        const corner = first + row * (steps + 1) + column;
        const above = corner + steps + 1;
        if (side > 0) part.faces.push(corner, corner + 1, above + 1, corner, above + 1, above);
        else part.faces.push(corner, above + 1, corner + 1, corner, above, above + 1);
      }
  }
  return part;
}

/** The x axis in the surface of a normal; where that is the normal, the limit from one side. */
function alongX([x, y, z]: Vector, side: number): Vector {
  const tangent: Vector = [1 - x * x, -x * y, -x * z];
  return Math.hypot(...tangent) > 1e-6 ? unit(tangent) : [0, 0, -side * Math.sign(x)];
}

/** A point of a square drawn into the rounded outline, and its place from the middle to the rim. */
function squircle(x: number, y: number): [number, number, number] {
  const square = Math.max(Math.abs(x), Math.abs(y));
  if (square === 0) return [0, 0, 0];
  const round = (Math.abs(x) ** CORNERS + Math.abs(y) ** CORNERS) ** (1 / CORNERS);
  const inside = Math.sin((Math.PI / 2) * square); // denser at the rim
  return [(x / round) * inside, (y / round) * inside, inside];
}

/** The gradient, upwards, of the surface on which the height is that of `pillow`. */
function gradient(x: number, y: number, height: number): Vector {
  const inside = (Math.abs(x) ** CORNERS + Math.abs(y) ** CORNERS) ** (1 / CORNERS);
  const flat = Math.max(height - 0.03 * (1 - inside * inside), 0) / THICKNESS;
  // (inside^RIM + flat^RIM = 1), flat depending on height and on inside
  const slope = inside ** (RIM - 1) + (flat ** (RIM - 1) * 0.06 * inside) / THICKNESS;
  const toward = (value: number) =>
    inside === 0 ? 0 : Math.sign(value) * (Math.abs(value) / inside) ** (CORNERS - 1);
  return [slope * toward(x), slope * toward(y), flat ** (RIM - 1) / THICKNESS];
}

/** A part of a mesh, its numbers as in `Mesh`. */
export interface Part {
  vertices: ArrayLike<number>;
  tangents: ArrayLike<number>;
  faces: ArrayLike<number>;
}

/** A grid of a surface that closes around; normals by finite differences, outwards; uv is (u, v). */
function surface(at: Surface, around: number, along: number): Part {
  const vertices: number[] = [];
  const tangents: number[] = [];
  const faces: number[] = [];
  const step = 1e-4;
  for (let row = 0; row <= along; row++) {
    // At a pole the derivative around vanishes: the normal is that of a ring beside it.
    const v = row / along;
    const beside = Math.min(Math.max(v, 2 * step), 1 - 2 * step);
    for (let column = 0; column <= around; column++) {
      const u = (column % around) / around;
      const du = minus(at((u + step) % 1, beside), at((u + 1 - step) % 1, beside));
      const dv = minus(at(u, beside + step), at(u, beside - step));
      // A vertex at a pole is that of one triangle, of whose middle it has the u.
      const [x, y] = at(u, v);
      const aside = Math.hypot(x, y) > 1e-6 ? 0 : row === 0 ? 0.5 : -0.5;
      const middle = Math.min(Math.max((column + aside) / around, 0), 1);
      vertices.push(...at(u, v), ...unit(cross(du, dv)), middle, v);
      tangents.push(...unit(du));
      if (row === along || column === around) continue;
      const first = row * (around + 1) + column;
      const above = first + around + 1;
      faces.push(first, first + 1, above + 1, first, above + 1, above);
    }
  }
  return { vertices, tangents, faces };
}

/** Parts as one mesh. */
export function joined(parts: readonly Part[]): Mesh {
  const of = (name: keyof Part) => parts.reduce((sum, part) => sum + part[name].length, 0);
  const vertices = new Float32Array(of("vertices"));
  const tangents = new Float32Array(of("tangents"));
  const faces = new Uint32Array(of("faces"));
  let [vertex, face] = [0, 0];
  for (const part of parts) {
    vertices.set(part.vertices, VERTEX_NUMBERS * vertex);
    tangents.set(part.tangents, 3 * vertex);
    for (let k = 0; k < part.faces.length; k++) faces[face++] = vertex + part.faces[k];
    vertex += part.vertices.length / VERTEX_NUMBERS;
  }
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let at = 0; at < vertices.length; at += VERTEX_NUMBERS)
    for (let axis = 0; axis < 3; axis++) {
      low[axis] = Math.min(low[axis], vertices[at + axis]);
      high[axis] = Math.max(high[axis], vertices[at + axis]);
    }
  const centre = [0, 1, 2].map((axis) => (low[axis] + high[axis]) / 2);
  let [radius, width] = [0, 0];
  for (let at = 0; at < vertices.length; at += VERTEX_NUMBERS) {
    const [x, y] = [vertices[at] - centre[0], vertices[at + 1] - centre[1]];
    radius = Math.max(radius, Math.hypot(x, y, vertices[at + 2] - centre[2]));
    width = Math.max(width, Math.hypot(x, y));
  }
  return {
    vertices,
    tangents,
    faces,
    centre: [centre[0], centre[1], centre[2]],
    radius,
    width,
    halfHeight: (high[2] - low[2]) / 2,
  };
}
