/** The reference: values of a stack with standard errors, which converge to the truth. */

import type { Stack } from "../api";
import { CHANNELS } from "../channels";
import type { CoatOfChannel } from "../features";
import { coatOfChannel } from "../surfaces";
import { bottomOf, type WalkedBottom } from "./bottoms";
import { reflection } from "./interface";
import { uniformNumbers } from "./random";
import { type Vector, vector } from "./vector";
import { Walk } from "./walk";

/** The estimate so far. */
export interface Estimate {
  /** Walks of every pair and channel. */
  readonly walks: number;
  /** (N, 3) the BRDF [1/sr], without cosine; zero below the horizon. */
  readonly f: Float32Array;
  /** (N, 3) its standard error; not a number before the second walk. */
  readonly error: Float32Array;
}

/** One channel of the stack; channels of equal parameters share it. */
interface Channel {
  readonly coats: readonly CoatOfChannel[];
  readonly bottom: WalkedBottom;
  readonly sums: Float64Array;
  readonly squares: Float64Array;
}

/** Random walks through a described stack, for given pairs of directions. */
export class Reference {
  private walks = 0;
  private readonly wi: readonly Vector[];
  private readonly wo: readonly Vector[];
  private readonly channels: readonly Channel[];
  private readonly uniform: () => number;

  /**
   * @param stack its bottom is described; codes cannot be walked on.
   * @param wi unit vectors (N, 3), and wo alike.
   * @param seed the same seed gives the same numbers.
   */
  constructor(stack: Stack, wi: Float32Array, wo: Float32Array, seed: number) {
    this.wi = vectorsOf(wi);
    this.wo = vectorsOf(wo);
    this.uniform = uniformNumbers(seed);
    this.channels = channelsOf(stack, this.wi.length);
  }

  /** Add walks to every pair and channel. */
  add(walks: number): void {
    for (const channel of new Set(this.channels)) {
      this.wi.forEach((wi, i) => {
        const wo = this.wo[i];
        if (!channel.coats.length || !(wi.z > 0 && wo.z > 0)) {
          return;
        }
        for (let k = 0; k < walks; k++) {
          const value = Walk.estimate(channel.coats, channel.bottom, wi, wo, this.uniform);
          channel.sums[i] += value;
          channel.squares[i] += value * value;
        }
      });
    }
    this.walks += walks;
  }

  /** The means so far, and their standard errors. */
  estimate(): Estimate {
    const f = new Float32Array(CHANNELS * this.wi.length);
    const error = new Float32Array(f.length);
    this.channels.forEach((channel, k) => {
      this.wi.forEach((wi, i) => {
        const mean = channel.coats.length ? channel.sums[i] / this.walks : 0;
        const square = channel.coats.length ? channel.squares[i] / this.walks : 0;
        const variance = Math.max(square - mean * mean, 0) / (this.walks - 1);
        f[CHANNELS * i + k] = mean + surfaceValue(channel, wi, this.wo[i]);
        error[CHANNELS * i + k] = channel.coats.length ? Math.sqrt(variance) : 0;
      });
    });
    return { walks: this.walks, f, error };
  }
}

/** What is known exactly: the reflection of the topmost interface, or of a bare bottom. */
function surfaceValue({ coats, bottom }: Channel, wi: Vector, wo: Vector): number {
  const [top] = coats;
  return top ? reflection(wi, wo, top.alpha, top.eta) : bottom.value(wi, wo).f;
}

function channelsOf({ bottom, coats }: Stack, pairs: number): Channel[] {
  if (bottom.kind === "codes") {
    throw new RangeError("a loaded material has no reference: its light cannot be followed");
  }
  const known = new Map<string, Channel>();
  return Array.from({ length: CHANNELS }, (_, k) => {
    const own = coats.map((coat) => coatOfChannel(coat, k));
    const parameters = Object.values(bottom).map((value) =>
      Array.isArray(value) ? value[k] : value,
    );
    const name = JSON.stringify([own, parameters]);
    const channel = known.get(name) ?? {
      coats: own,
      bottom: bottomOf(bottom, k),
      sums: new Float64Array(pairs),
      squares: new Float64Array(pairs),
    };
    known.set(name, channel);
    return channel;
  });
}

function vectorsOf(directions: Float32Array): Vector[] {
  return Array.from({ length: directions.length / 3 }, (_, i) =>
    vector(directions[3 * i], directions[3 * i + 1], directions[3 * i + 2]),
  );
}
