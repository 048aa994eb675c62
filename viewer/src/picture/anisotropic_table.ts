/**
 * The pairs of directions at which f of anisotropic materials is tabulated for bright lights.
 *
 * The axes are the slopes of the half vector along and across the tangent, in one quadrant, the
 * difference angle, and the azimuth of the difference about the half vector, modulo half a turn. That
 * azimuth counts in the frame that the shortest rotation brings from the normal to the half vector.
 */

/** Slopes of the half vector are logarithmic above NEAR, and end at FAR. */
export const NEAR = 0.004;
export const FAR = 12;

/** Least cosine to the normal: below it, the table continues the last value. */
const LEAST = 0.015;

/** Numbers of slopes along and across, of difference angles, and of azimuths of the difference. */
export interface AnisotropicSize {
  along: number;
  across: number;
  differences: number;
  turns: number;
}

export const ANISOTROPIC_COARSE: AnisotropicSize = {
  along: 24,
  across: 24,
  differences: 6,
  turns: 4,
};
export const ANISOTROPIC_FINE: AnisotropicSize = {
  along: 48,
  across: 48,
  differences: 10,
  turns: 6,
};

/** Directions wi, wo (N, 3), the slope along the tangent fastest, the azimuth slowest. */
export function anisotropicPairs(size: AnisotropicSize): { wi: Float32Array; wo: Float32Array } {
  const { along, across, differences, turns } = size;
  const count = along * across * differences * turns;
  const wi = new Float32Array(3 * count);
  const wo = new Float32Array(3 * count);
  const slope = (place: number, steps: number) =>
    NEAR * ((1 + FAR / NEAR) ** (place / (steps - 1)) - 1);
  let at = 0;
  for (let turn = 0; turn < turns; turn++)
    for (let step = 0; step < differences; step++)
      for (let j = 0; j < across; j++)
        for (let i = 0; i < along; i++, at += 3) {
          const [x, y] = [slope(i, along), slope(j, across)];
          const length = Math.hypot(x, y, 1);
          const half = [x / length, y / length, 1 / length] as const;
          const difference = (Math.PI / 2) * (step / (differences - 1));
          const azimuth = (Math.PI * turn) / turns;
          const flat = [
            Math.sin(difference) * Math.cos(azimuth),
            Math.sin(difference) * Math.sin(azimuth),
          ] as const;
          const share = (flat[0] * half[0] + flat[1] * half[1]) / (1 + half[2]);
          const aside = [
            flat[0] - share * half[0],
            flat[1] - share * half[1],
            -share * (half[2] + 1),
          ] as const;
          for (const [target, sign] of [
            [wi, 1],
            [wo, -1],
          ] as const)
            target.set(lifted(half, aside, Math.cos(difference), sign), at);
        }
  return { wi, wo };
}

/** A unit vector at least at the least cosine. */
function lifted(
  half: readonly [number, number, number],
  aside: readonly [number, number, number],
  cosine: number,
  sign: number,
): number[] {
  const [x, y, z] = half.map((axis, k) => cosine * axis + sign * aside[k]!) as [
    number,
    number,
    number,
  ];
  const raised = Math.max(z, LEAST);
  const length = Math.hypot(x, y, raised);
  return [x / length, y / length, raised / length];
}

/** (N, 4): the logarithm of f (N, 3), and a zero. */
export function brightTexels(f: Float32Array): Float32Array {
  const texels = new Float32Array((f.length / 3) * 4);
  for (let from = 0, to = 0; from < f.length; from += 3, to += 4)
    for (let k = 0; k < 3; k++) texels[to + k] = Math.log(Math.max(f[from + k]!, 1e-8));
  return texels;
}
