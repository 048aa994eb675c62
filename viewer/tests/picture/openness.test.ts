import { expect, test } from "vitest";
import { openness } from "../../src/picture/openness";
import type { Point } from "../../src/picture/outlines";

/** A curve of a sphere about the origin, from one height to another, seen from outside or inside. */
function arc(from: number, to: number, isInside: boolean): Point[] {
  const points = Array.from({ length: 65 }, (_, k): Point => {
    const angle = (Math.PI / 2) * (from + ((to - from) * k) / 64);
    return [Math.cos(angle), Math.sin(angle)];
  });
  return isInside ? points.reverse() : points;
}

test("nothing of a ball hides its light", () => {
  expect(Math.min(...openness([arc(-1, 1, false)])[0]!)).toBe(1);
});

test("everywhere in a hollow cap of a sphere, the opening has its share of the sphere's area", () => {
  // Of the light that leaves a point in a sphere by the cosine, equal areas get equal parts.
  for (const rim of [-0.5, 0, 0.5]) {
    const [open] = openness([arc(-1, rim, true)]);
    const share = (1 - Math.sin((Math.PI / 2) * rim)) / 2;
    // Not the rim itself; the rays resolve a twelfth of the polar angle's cosine squared.
    for (const value of open!.slice(6)) expect(Math.abs(value - share)).toBeLessThan(0.05);
  }
});
