/** Directions in the local frame: z is the normal. */

export interface Vector {
  readonly x: number;
  readonly y: number;
  readonly z: number;
}

export function vector(x: number, y: number, z: number): Vector {
  return { x, y, z };
}

export function dot(a: Vector, b: Vector): number {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

export function negated(a: Vector): Vector {
  return vector(-a.x, -a.y, -a.z);
}

/** Mirror a direction to the other side of the surface. */
export function flipped(a: Vector): Vector {
  return vector(a.x, a.y, -a.z);
}

export function normalised(x: number, y: number, z: number): Vector {
  const factor = 1 / Math.sqrt(x * x + y * y + z * z);
  return vector(x * factor, y * factor, z * factor);
}

/** The half vector of two directions. */
export function halfVector(a: Vector, b: Vector): Vector {
  return normalised(a.x + b.x, a.y + b.y, a.z + b.z);
}

/** Mirror direction `w` about the unit normal `m`, both pointing away. */
export function reflected(w: Vector, m: Vector): Vector {
  const twice = 2 * dot(w, m);
  return vector(twice * m.x - w.x, twice * m.y - w.y, twice * m.z - w.z);
}

/**
 * Refract `w` at a facet with normal `m` into the medium of relative index `eta`.
 *
 * @param cosT cosine of the refracted direction with -m (Walter et al. 2007, eq. 40).
 */
export function refracted(w: Vector, m: Vector, cosT: number, eta: number): Vector {
  const inverse = 1 / eta;
  const along = dot(w, m) * inverse - cosT;
  return vector(
    along * m.x - w.x * inverse,
    along * m.y - w.y * inverse,
    along * m.z - w.z * inverse,
  );
}

/** The unit vector at an angle and azimuth from an axis (Duff et al. 2017 for the tangents). */
export function aboutAxis(axis: Vector, cosine: number, phi: number): Vector {
  const sign = axis.z < 0 || Object.is(axis.z, -0) ? -1 : 1;
  const a = -1 / (sign + axis.z);
  const b = axis.x * axis.y * a;
  const sine = Math.sqrt(Math.max(1 - cosine * cosine, 0));
  const s = sine * Math.cos(phi);
  const t = sine * Math.sin(phi);
  return normalised(
    s * (1 + sign * axis.x * axis.x * a) + t * b + axis.x * cosine,
    s * (sign * b) + t * (sign + axis.y * axis.y * a) + axis.y * cosine,
    s * (-sign * axis.x) - t * axis.y + axis.z * cosine,
  );
}
