/** Half and difference angles (Rusinkiewicz 1998); see Python's `geometry.half_vector`. */

/** A unit vector in the local frame, z the normal. */
export type Direction = readonly [number, number, number];

/**
 * theta_h, theta_d in [0, pi/2] and phi_d in [0, pi] of directions above the horizon [rad].
 *
 * phi_d is modulo pi, so that every function of these angles is reciprocal.
 */
export function halfDifferenceAngles(wi: Direction, wo: Direction): [number, number, number] {
  const [x, y, z] = [wi[0] - wo[0], wi[1] - wo[1], wi[2] - wo[2]];
  const total = [wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]] as const;
  const size = Math.hypot(...total);
  const thetaD = Math.atan2(Math.hypot(x, y, z), size);
  const across = Math.hypot(total[0], total[1]);
  const [sinH, cosH] = [across / size, total[2] / size];
  // wi - wo in the frame about the half vector
  const [cosPhi, sinPhi] = across === 0 ? [1, 0] : [total[0] / across, total[1] / across];
  const along = cosH * (cosPhi * x + sinPhi * y) - sinH * z;
  const side = cosPhi * y - sinPhi * x;
  const sign = side < 0 || (side === 0 && along < 0) ? -1 : 1;
  return [Math.atan2(sinH, cosH), thetaD, Math.atan2(sign * side + 0, sign * along + 0)];
}

/** Whether both directions of the angles are above the horizon. */
export function isAboveHorizon(thetaH: number, thetaD: number, phiD: number): boolean {
  const least = Math.abs(Math.sin(thetaH) * Math.sin(thetaD) * Math.cos(phiD));
  return Math.cos(thetaH) * Math.cos(thetaD) > least;
}
