/** Control points of the objects, as in the scenes of the Python package. */

export type Point = readonly [radius: number, height: number];

/** Rows along a tube, of four control points across its half with y <= 0. */
export type Tube = readonly (readonly (readonly [number, number, number])[])[];

function points(numbers: readonly number[]): Point[] {
  return grouped(numbers, 2) as unknown as Point[];
}

function tube(numbers: readonly number[]): Tube {
  return grouped(grouped(numbers, 3), 4) as unknown as Tube;
}

function grouped<T>(all: readonly T[], size: number): T[][] {
  return Array.from({ length: all.length / size }, (_, k) => all.slice(size * k, size * (k + 1)));
}

/** A tea caddy; the groove is the rim of its lid. */
export const NATSUME = points([
  0, 0.035, 0.15, 0.035, 0.27, 0.032, 0.3, 0.01, 0.33, 0, 0.375, 0.03, 0.425, 0.12, 0.47, 0.26,
  0.497, 0.42, 0.503, 0.56, 0.502, 0.64, 0.501, 0.672, 0.498, 0.684, 0.491, 0.69, 0.491, 0.692,
  0.498, 0.698, 0.501, 0.71, 0.5, 0.76, 0.492, 0.85, 0.47, 0.93, 0.42, 0.99, 0.33, 1.028, 0.2, 1.05,
  0.1, 1.056, 0, 1.058,
]);

/**
 * A dish on a foot, in cubic Bézier segments: a flat ledge with a sharp edge, a concave stem, a round
 * body, a thin rim and a shallow hollow. Segments meet in edges between the parts.
 */
export const GOBLET = [
  line([0, 0], [0.39, 0]),
  [...points([0.39, 0, 0.405, 0, 0.41, 0.01]), ...line([0.41, 0.02], [0.41, 0.1])],
  line([0.41, 0.1], [0.23, 0.1]),
  points([0.23, 0.1, 0.15, 0.12, 0.13, 0.22, 0.2, 0.28]),
  points([
    0.2, 0.28, 0.4, 0.3, 0.56, 0.42, 0.59, 0.66, 0.6, 0.74, 0.61, 0.785, 0.66, 0.81, 0.672, 0.816,
    0.666, 0.828, 0.652, 0.824, 0.585, 0.8, 0.575, 0.77, 0.565, 0.7, 0.545, 0.58, 0.36, 0.53, 0,
    0.53,
  ]),
];

function line(from: Point, to: Point): Point[] {
  const at = (share: number): Point => [
    from[0] + share * (to[0] - from[0]),
    from[1] + share * (to[1] - from[1]),
  ];
  return [from, at(1 / 3), at(2 / 3), to];
}

/** A vase with a narrow neck. */
export const VASE = points([
  0, 0.04, 0.18, 0.04, 0.27, 0.03, 0.31, 0, 0.36, 0, 0.38, 0.05, 0.42, 0.2, 0.56, 0.5, 0.66, 0.85,
  0.67, 1.12, 0.58, 1.4, 0.38, 1.62, 0.24, 1.78, 0.2, 1.95, 0.22, 2.12, 0.3, 2.24, 0.335, 2.285,
  0.325, 2.3, 0.29, 2.28, 0.2, 2.16, 0.16, 1.95, 0.16, 1.8, 0.1, 1.7, 0, 1.68,
]);

/** A bowl. */
export const BOWL = points([
  0, 0.05, 0.2, 0.05, 0.26, 0.03, 0.28, 0, 0.33, 0, 0.35, 0.05, 0.48, 0.12, 0.66, 0.3, 0.76, 0.52,
  0.8, 0.7, 0.81, 0.745, 0.795, 0.76, 0.77, 0.745, 0.755, 0.7, 0.71, 0.53, 0.6, 0.33, 0.42, 0.17,
  0.24, 0.11, 0, 0.1,
]);

/** A flat plate. */
export const PLATE = points([
  0, 0.03, 0.3, 0.03, 0.4, 0.02, 0.43, 0, 0.46, 0, 0.48, 0.03, 0.62, 0.07, 0.8, 0.12, 0.87, 0.145,
  0.885, 0.16, 0.87, 0.175, 0.8, 0.165, 0.66, 0.13, 0.58, 0.095, 0.5, 0.085, 0.3, 0.08, 0, 0.08,
]);

/** The body of Martin Newell's teapot (University of Utah, 1975), in the form with a bottom. */
export const BODY = points([
  0, 0, 1.425, 0, 1.5, 0.075, 1.5, 0.15, 1.5, 0.225, 2, 0.45, 2, 0.9, 2, 1.35, 1.75, 1.875, 1.5,
  2.4, 1.4375, 2.53125, 1.3375, 2.53125, 1.4, 2.4,
]);

/** Its lid. */
export const LID = points([1.3, 2.4, 1.3, 2.55, 0.4, 2.55, 0.2, 2.7, 0, 2.85, 0.8, 3.15, 0, 3.15]);

/** Its handle. */
export const HANDLE = tube([
  -1.6, 0, 2.025, -1.6, -0.3, 2.025, -1.5, -0.3, 2.25, -1.5, 0, 2.25, -2.3, 0, 2.025, -2.3, -0.3,
  2.025, -2.5, -0.3, 2.25, -2.5, 0, 2.25, -2.7, 0, 2.025, -2.7, -0.3, 2.025, -3, -0.3, 2.25, -3, 0,
  2.25, -2.7, 0, 1.8, -2.7, -0.3, 1.8, -3, -0.3, 1.8, -3, 0, 1.8, -2.7, 0, 1.575, -2.7, -0.3, 1.575,
  -3, -0.3, 1.35, -3, 0, 1.35, -2.5, 0, 1.275, -2.5, -0.3, 1.275, -2.65, -0.3, 1.0875, -2.65, 0,
  1.0875, -2, 0, 1.05, -2, -0.3, 1.05, -1.9, -0.3, 0.75, -1.9, 0, 0.75,
]);

/** Its spout. */
export const SPOUT = tube([
  1.7, 0, 1.575, 1.7, -0.66, 1.575, 1.7, -0.66, 0.75, 1.7, 0, 0.75, 2.6, 0, 1.575, 2.6, -0.66,
  1.575, 3.1, -0.66, 0.975, 3.1, 0, 0.975, 2.3, 0, 2.25, 2.3, -0.25, 2.25, 2.4, -0.25, 2.175, 2.4,
  0, 2.175, 2.7, 0, 2.55, 2.7, -0.25, 2.55, 3.3, -0.25, 2.55, 3.3, 0, 2.55, 2.8, 0, 2.625, 2.8,
  -0.25, 2.625, 3.525, -0.25, 2.64375, 3.525, 0, 2.64375, 2.9, 0, 2.625, 2.9, -0.15, 2.625, 3.45,
  -0.15, 2.6625, 3.45, 0, 2.6625, 2.8, 0, 2.55, 2.8, -0.15, 2.55, 3.2, -0.15, 2.55, 3.2, 0, 2.55,
]);
