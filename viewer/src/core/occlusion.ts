/** Ambient occlusion and bent normals of a mesh, and its shadows, by depth maps along many axes. */

import { cross, type Vector } from "../picture/vectors";

/** Texels along a side of a depth map. */
const SIDE = 192;

/** Axes, each of two opposite directions: fewer if the mesh has many triangles. */
const LEAST_AXES = 64;
export const MOST_AXES = 256;
const MOST_DRAWN = 2e7;

/** Distance to the surface at which light is looked for [texels]: a flat surface does not hide itself. */
const BIAS = 1.5;

/** Texels along a side of the shadows on the ground. */
export const GROUND_SIDE = 128;

/** What a mesh hides of the light. */
export interface Occlusion {
  /**
   * The bent normal and the openness of each vertex, four numbers: the unit mean of the directions that
   * are not hidden, by their cosines, and the share of an even light that arrives (Landis 2002).
   */
  openings: Float32Array<ArrayBuffer>;
  /** (axes, `GROUND_SIDE`, `GROUND_SIDE`) 255 where the ground does not see an upward direction of `axisAt`. */
  shadows: Uint8Array<ArrayBuffer>;
}

/** Axes of shadows. */
export function axesOf(shadows: Uint8Array): number {
  return shadows.length / GROUND_SIDE ** 2;
}

/** An axis of many: points of a spiral, evenly on the upper hemisphere. */
function axisAt(axis: number, axes: number): { direction: Vector; right: Vector } {
  const z = (axis + 0.5) / axes;
  const phi = axis * Math.PI * (3 - Math.sqrt(5));
  const sine = Math.sqrt(1 - z * z);
  return {
    direction: [sine * Math.cos(phi), sine * Math.sin(phi), z],
    right: [-Math.sin(phi), Math.cos(phi), 0],
  };
}

/**
 * What a mesh hides of the light.
 *
 * @param vertices positions and unit normals, the first six of `stride` numbers a vertex.
 * @param ground half the side of the square of shadows about the origin, at height 0.
 */
export function occlusion(
  vertices: Float32Array,
  stride: number,
  faces: Uint32Array,
  ground: number,
): Occlusion {
  const count = vertices.length / stride;
  const map = new DepthMap(vertices, stride, count);
  const hidden = new Float32Array(4 * count);
  const cosines = new Float32Array(count);
  const fitting = Math.round((3 * MOST_DRAWN) / faces.length);
  const axes = Math.min(Math.max(fitting, LEAST_AXES), MOST_AXES);
  const shadows = new Uint8Array(axes * GROUND_SIDE ** 2);
  for (let axis = 0; axis < axes; axis++) {
    const { direction, right } = axisAt(axis, axes);
    map.draw(direction, right, faces);
    map.shade(shadows.subarray(axis * GROUND_SIDE ** 2), ground);
    for (let i = 0; i < count; i++) {
      const at = stride * i;
      const cosine =
        vertices[at + 3] * direction[0] +
        vertices[at + 4] * direction[1] +
        vertices[at + 5] * direction[2];
      const weight = Math.abs(cosine);
      cosines[i] += weight;
      const lost = weight * map.hidden(i, cosine);
      if (lost === 0) continue;
      for (let k = 0; k < 3; k++) hidden[4 * i + k] += Math.sign(cosine) * lost * direction[k];
      hidden[4 * i + 3] += lost;
    }
  }
  const openings = new Float32Array(4 * count);
  for (let i = 0; i < count; i++) {
    // All directions by their cosines sum up to two thirds of the cosines' sum, along the normal.
    const bent = [0, 1, 2].map(
      (k) => (2 / 3) * cosines[i] * vertices[stride * i + 3 + k] - hidden[4 * i + k],
    );
    const length = Math.hypot(...bent) || 1;
    openings.set([...bent.map((part) => part / length), 1 - hidden[4 * i + 3] / cosines[i]], 4 * i);
  }
  return { openings, shadows };
}

/** Depths along an axis, the nearest from both of its ends. */
class DepthMap {
  private readonly highest = new Float32Array(SIDE * SIDE);
  private readonly lowest = new Float32Array(SIDE * SIDE);
  /** Positions of the vertices in the map, and shifts along their normals [texels]. */
  private readonly places: Float32Array;
  private readonly centre: number[];
  private readonly scale: number;
  /** Rows (a, b, shift) from (x, y) on the ground to the map. */
  private readonly fromGround: Vector[] = [];

  constructor(
    private readonly vertices: Float32Array,
    private readonly stride: number,
    private readonly count: number,
  ) {
    this.places = new Float32Array(6 * count);
    const axes = [0, 1, 2].map((k) => {
      let [low, high] = [Infinity, -Infinity];
      for (let at = k; at < vertices.length; at += stride) {
        low = Math.min(low, vertices[at]);
        high = Math.max(high, vertices[at]);
      }
      return { middle: (low + high) / 2, half: (high - low) / 2 };
    });
    this.centre = axes.map(({ middle }) => middle);
    this.scale = (SIDE / 2 - 4) / (Math.hypot(...axes.map(({ half }) => half)) || 1);
  }

  /** Draw all faces along an axis; `right` is perpendicular to it. */
  draw(axis: Vector, right: Vector, faces: Uint32Array): void {
    const { vertices, stride, places, scale, centre } = this;
    [right, cross(axis, right), axis].forEach(([a, b, c], k) => {
      const middle = (a * centre[0] + b * centre[1] + c * centre[2]) * scale - SIDE / 2;
      this.fromGround[k] = [a * scale, b * scale, -middle];
      for (let i = 0; i < this.count; i++) {
        const at = stride * i;
        const along = a * vertices[at] + b * vertices[at + 1] + c * vertices[at + 2];
        const slant = a * vertices[at + 3] + b * vertices[at + 4] + c * vertices[at + 5];
        places[6 * i + k] = along * scale - middle;
        places[6 * i + 3 + k] = BIAS * slant;
      }
    });
    this.highest.fill(-Infinity);
    this.lowest.fill(Infinity);
    for (let at = 0; at < faces.length; at += 3)
      this.cover(6 * faces[at], 6 * faces[at + 1], 6 * faces[at + 2]);
  }

  /** Set the texels of a square on the ground that the mesh hides from the axis' upper end. */
  shade(shadow: Uint8Array, half: number): void {
    const { highest, fromGround } = this;
    const [[ax, bx, cx], [ay, by, cy]] = fromGround as [Vector, Vector];
    const step = (2 * half) / GROUND_SIDE;
    for (let at = 0; at < GROUND_SIDE ** 2; at++) {
      const x = ((at % GROUND_SIDE) + 0.5) * step - half;
      const y = (Math.floor(at / GROUND_SIDE) + 0.5) * step - half;
      const column = Math.floor(ax * x + bx * y + cx);
      const row = Math.floor(ay * x + by * y + cy);
      if (column < 0 || row < 0 || column >= SIDE || row >= SIDE) continue;
      if (highest[SIDE * row + column] > -Infinity) shadow[at] = 255;
    }
  }

  /** Keep the depths of a triangle at the middles of texels. */
  private cover(a: number, b: number, c: number): void {
    const { places, highest, lowest } = this;
    const [ax, ay, az] = [places[a], places[a + 1], places[a + 2]];
    const [bx, by, bz] = [places[b] - ax, places[b + 1] - ay, places[b + 2] - az];
    const [cx, cy, cz] = [places[c] - ax, places[c + 1] - ay, places[c + 2] - az];
    const left = Math.ceil(ax + Math.min(0, bx, cx) - 0.5);
    const right = Math.floor(ax + Math.max(0, bx, cx) - 0.5);
    if (right < left) return; // most triangles are smaller than texels
    const bottom = Math.ceil(ay + Math.min(0, by, cy) - 0.5);
    const top = Math.floor(ay + Math.max(0, by, cy) - 0.5);
    const area = bx * cy - by * cx;
    if (top < bottom || area === 0) return;
    for (let row = bottom; row <= top; row++)
      for (let column = left; column <= right; column++) {
        const [x, y] = [column + 0.5 - ax, row + 0.5 - ay];
        const u = (x * cy - y * cx) / area;
        const v = (y * bx - x * by) / area;
        if (u < -1e-6 || v < -1e-6 || u + v > 1 + 1e-6) continue;
        const depth = az + u * bz + v * cz;
        const texel = SIDE * row + column;
        if (depth > highest[texel]) highest[texel] = depth;
        if (depth < lowest[texel]) lowest[texel] = depth;
      }
  }

  /** Share of a vertex's light that is hidden along the axis, on the side of the cosine's sign. */
  hidden(vertex: number, cosine: number): number {
    const { places } = this;
    const at = 6 * vertex;
    const x = places[at] + places[at + 3] - 0.5;
    const y = places[at + 1] + places[at + 4] - 0.5;
    const depth = places[at + 2] + places[at + 5];
    const [column, row] = [Math.floor(x), Math.floor(y)];
    const [right, up] = [x - column, y - row];
    const [map, sign] = cosine > 0 ? [this.highest, 1] : [this.lowest, -1];
    let share = 0;
    for (let k = 0; k < 4; k++) {
      const above = sign * (map[SIDE * (row + (k >> 1)) + column + (k & 1)] - depth);
      if (above > 0)
        share += (k & 1 ? right : 1 - right) * (k >> 1 ? up : 1 - up) * Math.min(above, 1);
    }
    return share;
  }
}
