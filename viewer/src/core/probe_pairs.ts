/** The probe pairs, at which the encoder needs a BRDF's values; see Python's `geometry`. */

import { Pairs, type Widths } from "./features";
import { PROBE_PAIRS } from "./formulas";

const { HALF_ANGLE_SHARE, MIN_TANGENT, MAX_TANGENT, MAX_DIFFERENCE, MIN_COSINE } = PROBE_PAIRS;

type Vector = readonly [number, number, number];

/**
 * Steps of Roberts' R sequence (2018): point n is (1/2 + n step) mod 1 in each dimension.
 *
 * Its base is the root of x^(d+1) = x + 1.
 */
export function sequenceSteps(dimensions: number): number[] {
  let base = 2;
  for (let round = 0; round < 64; round++) {
    base = (1 + base) ** (1 / (dimensions + 1));
  }
  return Array.from({ length: dimensions }, (_, k) => base ** -(k + 1));
}

/** The n probe pairs. */
export function probePairs(n: number, widths: Widths): Pairs {
  const { wi, wo } = probeDirections(n, widths);
  return Pairs.of(wi, wo, widths);
}

/** The directions (n, 3) of the probe pairs, which are float32 unit vectors. */
export function probeDirections(n: number, widths: Widths): { wi: Float32Array; wo: Float32Array } {
  const first = Math.round(n * HALF_ANGLE_SHARE);
  const chosen =
    widths === 1
      ? [...halfAnglePairs(first), ...hemispherePairs(n - first)]
      : [...slopePairs(first), ...turnedHemispherePairs(n - first)];
  const wi = Float32Array.from(chosen.flatMap(([w]) => [...w]));
  const wo = Float32Array.from(chosen.flatMap(([, w]) => [...w]));
  return { wi, wo };
}

function points(count: number): Vector[] {
  const [a, b, c] = sequenceSteps(3) as [number, number, number];
  return Array.from({ length: count }, (_, n) => [
    (0.5 + (n + 1) * a) % 1,
    (0.5 + (n + 1) * b) % 1,
    (0.5 + (n + 1) * c) % 1,
  ]);
}

/** Pairs log-uniform in tan theta_h about difference directions of one quadrant. */
function halfAnglePairs(count: number): [Vector, Vector][] {
  const pairs: [Vector, Vector][] = [];
  for (const [u, v, w] of points(8 * count)) {
    const tangent = MIN_TANGENT * (MAX_TANGENT / MIN_TANGENT) ** u;
    const pair = aboutHalfVector(tangent, MAX_DIFFERENCE * v, 0.5 * Math.PI * w);
    if (pair.every((direction) => direction[2] > MIN_COSINE) && pairs.length < count) {
      pairs.push(pair);
    }
  }
  return pairs;
}

/** Points of the sequence in four dimensions. */
function points4(count: number): (readonly [number, number, number, number])[] {
  const steps = sequenceSteps(4);
  return Array.from({ length: count }, (_, n) => {
    const at = (k: number) => (0.5 + (n + 1) * (steps[k] ?? 0)) % 1;
    return [at(0), at(1), at(2), at(3)];
  });
}

/**
 * Pairs whose half vector has independent log-uniform slopes, in one quadrant by mirroring.
 *
 * Every second one has a log-uniform tan theta_h and a uniform azimuth instead.
 */
function slopePairs(count: number): [Vector, Vector][] {
  const pairs: [Vector, Vector][] = [];
  const range = Math.log(MAX_TANGENT / MIN_TANGENT);
  points4(8 * count).forEach(([u, v, w, t], n) => {
    const along = MIN_TANGENT * Math.exp(range * u);
    const across = MIN_TANGENT * Math.exp(range * t);
    const isRadial = n % 2 === 0;
    const tangent = isRadial ? along : Math.hypot(along, across);
    const azimuth = isRadial ? 0.5 * Math.PI * t : Math.atan2(across, along);
    const pair = aboutHalfVector(tangent, MAX_DIFFERENCE * v, Math.PI * w);
    const isAbove = pair.every((direction) => direction[2] > MIN_COSINE);
    if (isAbove && tangent <= MAX_TANGENT && pairs.length < count) {
      pairs.push([turned(pair[0], azimuth), turned(pair[1], azimuth)]);
    }
  });
  return pairs;
}

/** Pairs with independent uniform cosines and azimuths, wi in one quadrant by mirroring. */
function turnedHemispherePairs(count: number): [Vector, Vector][] {
  const turns = points4(count);
  return hemispherePairs(count).map(([wi, wo], n) => {
    const [, , side, turn] = turns[n];
    const azimuth = 0.5 * Math.PI * turn;
    return [turned(wi, azimuth), turned(wo, azimuth + (side > 0.5 ? Math.PI : 0))];
  });
}

function turned([x, y, z]: Vector, azimuth: number): Vector {
  const [cos, sin] = [Math.cos(azimuth), Math.sin(azimuth)];
  return [cos * x - sin * y, sin * x + cos * y, z];
}

/** The pair at difference angles about the half vector of a tangent, at the azimuth 0. */
function aboutHalfVector(tangent: number, thetaD: number, phiD: number): [Vector, Vector] {
  const cosH = 1 / Math.sqrt(1 + tangent * tangent);
  const sinH = tangent * cosH;
  const up = Math.cos(thetaD);
  const along = Math.sin(thetaD) * Math.cos(phiD);
  const across = Math.sin(thetaD) * Math.sin(phiD);
  const direction = (x: number, y: number): Vector => [
    cosH * x + sinH * up,
    y,
    cosH * up - sinH * x,
  ];
  return [direction(along, across), direction(-along, -across)];
}

/** Pairs with independent uniform cosines and a uniform difference of azimuths. */
function hemispherePairs(count: number): [Vector, Vector][] {
  return points(count).map(([u, v, w]) => {
    const cosI = MIN_COSINE + (1 - MIN_COSINE) * u;
    const cosO = MIN_COSINE + (1 - MIN_COSINE) * v;
    const sinI = Math.sqrt(1 - cosI * cosI);
    const sinO = Math.sqrt(1 - cosO * cosO);
    const phi = Math.PI * w;
    return [
      [sinI, 0, cosI],
      [sinO * Math.cos(phi), sinO * Math.sin(phi), cosO],
    ];
  });
}
