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

/** The n probe pairs, whose directions are float32 unit vectors. */
export function probePairs(n: number, widths: Widths): Pairs {
  const first = Math.round(n * HALF_ANGLE_SHARE);
  const chosen = [...halfVectorPairs(first, widths), ...hemispherePairs(n - first, widths)];
  const wi = Float32Array.from(chosen.flatMap(([w]) => w));
  const wo = Float32Array.from(chosen.flatMap(([, w]) => w));
  return Pairs.of(wi, wo, widths);
}

/** Points of the sequence; those of two widths have a fourth number. */
function points(count: number, widths: Widths): number[][] {
  const steps = sequenceSteps(2 + widths);
  return Array.from({ length: count }, (_, n) => steps.map((step) => (0.5 + (n + 1) * step) % 1));
}

/**
 * Pairs log-uniform in tan theta_h about difference directions, in one quadrant by mirroring.
 *
 * With two widths, half vectors are at all azimuths. Those of every second pair have independent
 * log-uniform slopes along both axes instead.
 */
function halfVectorPairs(count: number, widths: Widths): [Vector, Vector][] {
  const pairs: [Vector, Vector][] = [];
  const range = Math.log(MAX_TANGENT / MIN_TANGENT);
  points(8 * count, widths).forEach(([u, v, w, t = 0], n) => {
    const along = MIN_TANGENT * Math.exp(range * u);
    const across = MIN_TANGENT * Math.exp(range * t);
    const isRadial = widths === 1 || n % 2 === 0;
    const tangent = isRadial ? along : Math.hypot(along, across);
    const azimuth = isRadial ? 0.5 * Math.PI * t : Math.atan2(across, along);
    const pair = aboutHalfVector(tangent, MAX_DIFFERENCE * v, 0.5 * Math.PI * widths * w);
    const isAbove = pair.every((direction) => direction[2] > MIN_COSINE);
    if (isAbove && tangent <= MAX_TANGENT && pairs.length < count)
      pairs.push([turned(pair[0], azimuth), turned(pair[1], azimuth)]);
  });
  return pairs;
}

/**
 * Pairs with independent uniform cosines and azimuths, wi in one quadrant by mirroring.
 *
 * With one width, wi is at the azimuth 0.
 */
function hemispherePairs(count: number, widths: Widths): [Vector, Vector][] {
  const turns = points(count, widths);
  return points(count, 1).map(([u, v, w], n) => {
    const [, , side, turn] = turns[n];
    const azimuth = widths === 1 ? 0 : 0.5 * Math.PI * turn;
    const phi = azimuth + Math.PI * (w + (widths === 2 && side > 0.5 ? 1 : 0));
    const at = (share: number, angle: number) => {
      const cosine = MIN_COSINE + (1 - MIN_COSINE) * share;
      return turned([Math.sqrt(1 - cosine * cosine), 0, cosine], angle);
    };
    return [at(u, azimuth), at(v, phi)];
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
