/** Control points of the outlines of objects that only the page has. */

export type Point = readonly [radius: number, height: number];

function points(numbers: readonly number[]): Point[] {
  return Array.from({ length: numbers.length / 2 }, (_, k) => [numbers[2 * k], numbers[2 * k + 1]]);
}

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
