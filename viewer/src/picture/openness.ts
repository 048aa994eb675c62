/** How much of the light on a turned object the object itself hides. */

import type { Point } from "./outlines";

/** Rays in polar angle and in half the azimuth: what is turned is its own mirror image. */
const [POLAR, AZIMUTHS] = [12, 16];

/** Distance to the surface at which a ray begins, in the object's units. */
const BIAS = 2e-3;

/**
 * The share of an even light, by the cosine, that reaches each point of curves (radius, height) that
 * are turned about the axis. The outside is on the right of each curve.
 */
export function openness(curves: readonly (readonly Point[])[]): number[][] {
  const segments = curves.flatMap((curve) =>
    curve.slice(1).map((end, k) => [curve[k]!, end] as const),
  );
  return curves.map((curve) =>
    curve.map((point, k) => {
      const [from, to] = [curve[Math.max(k - 1, 0)]!, curve[Math.min(k + 1, curve.length - 1)]!];
      const length = Math.hypot(to[0] - from[0], to[1] - from[1]) || 1;
      const [x, z] = [(to[1] - from[1]) / length, (from[0] - to[0]) / length];
      const start: Point = [point[0] + BIAS * x, point[1] + BIAS * z];
      let open = 0;
      for (let i = 0; i < POLAR; i++) {
        const sine = Math.sqrt((i + 0.5) / POLAR); // rays by the cosine
        const cosine = Math.sqrt(1 - sine * sine);
        for (let j = 0; j < AZIMUTHS; j++) {
          const angle = (Math.PI * (j + 0.5)) / AZIMUTHS;
          const along = sine * Math.cos(angle);
          const ray = [
            cosine * x - along * z,
            sine * Math.sin(angle),
            cosine * z + along * x,
          ] as const;
          if (!segments.some((segment) => hits(start, ray, segment))) open++;
        }
      }
      return open / (POLAR * AZIMUTHS);
    }),
  );
}

/** Whether a ray from (radius, 0, height) meets the cone of a segment. */
function hits(
  [x, z]: Point,
  [dx, dy, dz]: readonly [number, number, number],
  [[fromRadius, from], [toRadius, to]]: readonly [Point, Point],
): boolean {
  if (Math.abs(to - from) < 1e-6) {
    const t = (from - z) / dz;
    const radius = Math.hypot(x + t * dx, t * dy);
    return t > 0 && (radius - fromRadius) * (radius - toRadius) < 0;
  }
  // (x + t dx)^2 + (t dy)^2 = (radius + t slope dz)^2
  const slope = (toRadius - fromRadius) / (to - from);
  const radius = fromRadius + slope * (z - from);
  const a = dx * dx + dy * dy - (slope * dz) ** 2 || 1e-12;
  const b = x * dx - slope * dz * radius;
  const root = b * b - a * (x * x - radius * radius);
  if (root < 0) return false;
  return [(-b - Math.sqrt(root)) / a, (-b + Math.sqrt(root)) / a].some((t) => {
    const place = (z + t * dz - from) / (to - from);
    return t > 0 && place >= 0 && place < 1;
  });
}
