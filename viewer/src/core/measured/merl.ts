/** MERL tables: isotropic BRDFs of Matusik et al. 2003; see Python's `measured.merl`. */

import { FileError } from "../safetensors";
import { nearestValid } from "./fill";
import { type Direction, halfDifferenceAngles, isAboveHorizon } from "./half_vector";

/** Bins along theta_h, theta_d and phi_d. */
const [HALVES, DIFFERENCES, TURNS] = [90, 90, 180] as const;
const BINS = HALVES * DIFFERENCES * TURNS;

/** Factors of the planes R, G and B that give values in 1/sr. */
const SCALE = [1 / 1500, 1.15 / 1500, 1.66 / 1500] as const;

/** Size of the header and of every file [bytes]. */
const HEADER = 12;
const FILE_SIZE = HEADER + 3 * 8 * BINS;

/** Whether a file begins with the dimensions of all MERL tables. */
export function isMerl(file: ArrayBuffer): boolean {
  if (file.byteLength < HEADER) return false;
  const view = new DataView(file);
  return [HALVES, DIFFERENCES, TURNS].every((n, place) => view.getInt32(4 * place, true) === n);
}

/** A BRDF by its table: trilinear between the bins' centres, along sqrt(theta_h), theta_d, phi_d. */
export class Merl {
  readonly isReciprocal = true;
  /** (bins, 3) [1/sr]. */
  private readonly table: Float32Array;

  /** @throws FileError if the file has another size, or holds no valid numbers. */
  constructor(file: ArrayBuffer) {
    if (file.byteLength !== FILE_SIZE) {
      const kind = file.byteLength < FILE_SIZE ? "truncated" : "too long";
      throw new FileError(
        `The MERL table is ${kind} (${file.byteLength} bytes, not ${FILE_SIZE}); obtain it again.`,
      );
    }
    this.table = valuesOf(file);
    fillInvalid(this.table);
  }

  /** Linear RGB [1/sr] for directions above the horizon. */
  f(wi: Direction, wo: Direction): [number, number, number] {
    const [thetaH, thetaD, phiD] = halfDifferenceAngles(wi, wo);
    const half = between(Math.sqrt(thetaH / (Math.PI / 2)), HALVES, false);
    const difference = between(thetaD / (Math.PI / 2), DIFFERENCES, false);
    const turn = between(phiD / Math.PI, TURNS, true);
    const result: [number, number, number] = [0, 0, 0];
    for (const [i, weightI] of half) {
      for (const [j, weightJ] of difference) {
        for (const [k, weightK] of turn) {
          const at = 3 * ((i * DIFFERENCES + j) * TURNS + k);
          const weight = weightI * weightJ * weightK;
          for (let channel = 0; channel < 3; channel++) {
            result[channel] += weight * this.table[at + channel];
          }
        }
      }
    }
    return result;
  }
}

function valuesOf(file: ArrayBuffer): Float32Array {
  const view = new DataView(file, HEADER);
  const table = new Float32Array(3 * BINS);
  SCALE.forEach((scale, channel) => {
    for (let bin = 0; bin < BINS; bin++) {
      table[3 * bin + channel] = view.getFloat64(8 * (channel * BINS + bin), true) * scale;
    }
  });
  if (!table.every(Number.isFinite)) {
    throw new FileError("The MERL table has bins that are not finite; obtain it again.");
  }
  return table;
}

/** Overwrite bins without a measurement, whose marks are negative, or below the horizon. */
function fillInvalid(table: Float32Array): void {
  const size = DIFFERENCES * TURNS;
  const filled: number[] = [];
  for (let i = 0; i < HALVES; i++) {
    const thetaH = ((i + 0.5) / HALVES) ** 2 * (Math.PI / 2);
    const first = i * size;
    const valid = Uint8Array.from({ length: size }, (_, place) => {
      const thetaD = ((Math.floor(place / TURNS) + 0.5) / DIFFERENCES) * (Math.PI / 2);
      const phiD = (((place % TURNS) + 0.5) / TURNS) * Math.PI;
      const at = 3 * (first + place);
      const isMeasured = table[at] >= 0 && table[at + 1] >= 0 && table[at + 2] >= 0;
      return Number(isMeasured && isAboveHorizon(thetaH, thetaD, phiD));
    });
    if (!valid.includes(1)) continue;
    filled.push(i);
    nearestValid(valid, DIFFERENCES, TURNS).forEach((source, place) => {
      const from = 3 * (first + source);
      table.copyWithin(3 * (first + place), from, from + 3);
    });
  }
  if (filled.length === 0) {
    throw new FileError("The MERL table has no valid bin, all are negative; obtain it again.");
  }
  // A slice without valid bins takes the nearest one.
  for (let i = 0; i < HALVES; i++) {
    const nearest = filled.reduce((a, b) => (Math.abs(b - i) < Math.abs(a - i) ? b : a));
    if (nearest !== i) {
      table.copyWithin(3 * i * size, 3 * nearest * size, 3 * (nearest + 1) * size);
    }
  }
}

/** The two bins whose centres enclose u in [0, 1], and their weights. */
function between(u: number, bins: number, isPeriodic: boolean): [number, number][] {
  const place = u * bins - 0.5;
  if (isPeriodic) {
    const lower = Math.floor(place);
    const weight = place - lower;
    return [
      [(lower + bins) % bins, 1 - weight],
      [(lower + 1) % bins, weight],
    ];
  }
  const clamped = Math.min(Math.max(place, 0), bins - 1);
  const lower = Math.floor(clamped);
  return [
    [lower, 1 - (clamped - lower)],
    [Math.min(lower + 1, bins - 1), clamped - lower],
  ];
}
