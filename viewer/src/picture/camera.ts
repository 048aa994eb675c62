/** The camera that looks at an object: where it stands, and its projection. */

import type { View } from "../state/state";
import type { Mesh } from "./meshes";
import { dot, type Vector } from "./vectors";

export interface Camera {
  eye: Vector;
  /** Half the picture's width and height at the distance of 1, and the direction to its middle. */
  right: Vector;
  up: Vector;
  forward: Vector;
  /** World to clip space, column by column. */
  projection: number[];
}

/** Share of the picture that the object fills at zoom 1. */
const FILLED = 0.8;

/** From lower than this the object keeps its size [degrees]. */
const LOW = 18;

/**
 * The camera of a view.
 *
 * @param aspect the picture's width over its height.
 * @param jitter shift of the picture, in its halves: for smooth edges.
 */
export function cameraOf(
  mesh: Mesh,
  view: View,
  aspect: number,
  jitter: readonly [number, number] = [0, 0],
): Camera {
  const distance = mesh.radius / (FILLED * Math.tan((view.fov * Math.PI) / 360));
  const steep = (Math.max(view.elevation, LOW) * Math.PI) / 180;
  const tall = mesh.halfHeight * Math.cos(steep) + mesh.width * Math.sin(steep);
  const size = Math.max(tall, mesh.width / aspect) / FILLED;
  const halfHeight = size / (distance * view.zoom);
  const halfWidth = halfHeight * aspect;

  const azimuth = (view.azimuth * Math.PI) / 180;
  const elevation = (view.elevation * Math.PI) / 180;
  const back: Vector = [
    Math.cos(elevation) * Math.sin(azimuth),
    -Math.cos(elevation) * Math.cos(azimuth),
    Math.sin(elevation),
  ];
  const side: Vector = [Math.cos(azimuth), Math.sin(azimuth), 0];
  const top: Vector = [
    -Math.sin(elevation) * Math.sin(azimuth),
    Math.sin(elevation) * Math.cos(azimuth),
    Math.cos(elevation),
  ];
  const [along, upward] = view.pan;
  const eye = mesh.centre.map(
    (x, k) => x + distance * back[k] - size * (along * side[k] + upward * top[k]),
  ) as unknown as Vector;
  const near = distance - 1.5 * mesh.radius;
  const far = distance + 1.5 * mesh.radius;

  const row = (axis: Vector, scale: number): number[] => [
    ...axis.map((x) => x * scale),
    -scale * dot(axis, eye),
  ];
  const forward: Vector = [-back[0], -back[1], -back[2]];
  const depth = row(forward, 1);
  const x = row(side, 1 / halfWidth).map((value, k) => value + jitter[0] * depth[k]);
  const y = row(top, 1 / halfHeight).map((value, k) => value + jitter[1] * depth[k]);
  const z = row(forward, (far + near) / (far - near));
  z[3] -= (2 * far * near) / (far - near);
  const rows = [x, y, z, depth];
  return {
    eye,
    right: [side[0] * halfWidth, side[1] * halfWidth, side[2] * halfWidth],
    up: [top[0] * halfHeight, top[1] * halfHeight, top[2] * halfHeight],
    forward,
    projection: [0, 1, 2, 3].flatMap((column) => rows.map((values) => values[column])),
  };
}

/** The camera below the ground that sees the object as it is reflected there. */
export function mirrored({ eye, projection, ...camera }: Camera): Camera {
  const flipped = projection.map((x, at) => (Math.floor(at / 4) === 2 ? -x : x));
  return { ...camera, eye: [eye[0], eye[1], -eye[2]], projection: flipped };
}
