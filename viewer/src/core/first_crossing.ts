/**
 * The first crossing: a coated material whose light crosses the interface once on either way, from
 * which the layering network begins; see Python's `nets.first_crossing`.
 */

import type { Basis } from "./basis";
import { clampedLog } from "./f_table";
import { type CoatOfChannel, Pairs } from "./features";
import { CODE_FIT, FIRST_CROSSING, facetCosine, lobeShape } from "./formulas";
import { addRow, solve } from "./least_squares";
import { reflectance } from "./lobe";
import { probePairs } from "./probe_pairs";
import { dot, normalised, type Vector, vector } from "./walk/vector";

const { NODES, LEAST_AMPLITUDE, LARGEST_AMPLITUDE, LEAST_COSINE, WIDENING, FLOOR } = FIRST_CROSSING;
const SPAN = LARGEST_AMPLITUDE - LEAST_AMPLITUDE;

export class FirstCrossing {
  private readonly pairs: readonly (readonly [wi: Vector, wo: Vector])[];
  /** (NODES) the functions (N, 1 + K) at the pairs inside, for indices of equal steps. */
  private readonly inside: readonly Float32Array[];
  /** (N) the mean of the basis at the pairs. */
  private readonly mean: Float32Array;
  /** (K, N) from logarithms less the mean to codes. */
  private readonly solution: Float32Array;

  /** At `count` probe pairs. */
  constructor(basis: Basis, count: number) {
    const { directions: w } = probePairs(count, 1);
    this.pairs = Array.from({ length: count }, (_, p) => [
      vector(w[6 * p], w[6 * p + 1], w[6 * p + 2]),
      vector(w[6 * p + 3], w[6 * p + 4], w[6 * p + 5]),
    ]);
    const rowsAt = (change: (w: Vector) => Vector) => {
      const side = (k: 0 | 1) =>
        Float32Array.from(this.pairs.flatMap((pair) => Object.values(change(pair[k]))));
      return Float32Array.from(basis.functions(Pairs.of(side(0), side(1)), count));
    };
    this.inside = Array.from({ length: NODES }, (_, node) => {
      const amplitude = LEAST_AMPLITUDE + (node / (NODES - 1)) * SPAN;
      return rowsAt((w) => refracted(w, (1 + amplitude) / (1 - amplitude)));
    });
    const rows = rowsAt((w) => w);
    const width = rows.length / count;
    this.mean = Float32Array.from(this.pairs, (_, p) => rows[p * width]);
    const size = width - 1;
    const normal = basis.prior.map((value) => CODE_FIT.PRIOR * value);
    const right = new Float64Array(size * count);
    const none = new Float64Array(size);
    this.pairs.forEach((_, p) => {
      addRow(none, normal, rows, p * width + 1, 0, 1 / count);
      for (let k = 0; k < size; k++) right[k * count + p] = rows[p * width + 1 + k] / count;
    });
    this.solution = Float32Array.from(solve(normal, right, size));
  }

  /** The numbers (K) beside the lobe, of those of a bottom under a coat. */
  code(rest: Float32Array, lobe: ArrayLike<number>, coat: CoatOfChannel): Float64Array {
    const count = this.pairs.length;
    const { eta } = coat;
    const amplitude = ((eta - 1) / (eta + 1) - LEAST_AMPLITUDE) / SPAN;
    const place = Math.min(Math.max(amplitude, 0), 1) * (NODES - 1);
    const node = Math.min(Math.floor(place), NODES - 2);
    const [low, high, share] = [this.inside[node], this.inside[node + 1], place - node];
    const width = low.length / count;
    const logs = this.pairs.map((pair, p) => {
      const at = p * width;
      const between = (k: number) => low[at + k] + share * (high[at + k] - low[at + k]);
      let log = between(0);
      for (let k = 1; k < width; k++) log += between(k) * rest[k - 1];
      return crossedLog(clampedLog(log), lobe, coat, ...pair) - this.mean[p];
    });
    return Float64Array.from(rest, (_, k) =>
      logs.reduce((sum, log, p) => sum + log * this.solution[k * count + p], 0),
    );
  }
}

/** The direction inside of one outside. */
function refracted(w: Vector, eta: number): Vector {
  const [x, y] = [w.x / eta, w.y / eta];
  return normalised(x, y, Math.sqrt(Math.max(1 - x * x - y * y, LEAST_COSINE ** 2)));
}

/** ln f of what crosses once; restLog: ln f of the bottom's rest at the refracted pair. */
function crossedLog(
  restLog: number,
  lobe: ArrayLike<number>,
  { alpha, eta, albedo, sigmaT, g }: CoatOfChannel,
  wi: Vector,
  wo: Vector,
): number {
  const [i, o] = [refracted(wi, eta), refracted(wo, eta)];
  const pair = [i.x, i.y, i.z, o.x, o.y, o.z] as const;
  const width = Math.sqrt(lobe[0] ** 2 + WIDENING * ((1 - 1 / eta) * alpha) ** 2);
  const own = lobeShape(width, ...pair) * reflectance(lobe, 0, facetCosine(...pair));
  const passed = Math.exp(-sigmaT * (1 / i.z + 1 / o.z));
  const phase = (1 - g * g) / (4 * Math.PI) / (1 + g * g + 2 * g * dot(i, o)) ** 1.5;
  const scattered = (albedo * phase * (1 - passed)) / (i.z + o.z);
  return Math.log((Math.exp(restLog) + own) * passed + scattered + FLOOR);
}
