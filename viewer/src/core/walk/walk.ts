/**
 * The position-free random walk through a layered stack (Guo, Hasan and Zhao 2018), one channel.
 *
 * One walk estimates f(wi, wo) [1/sr] without the reflection of the topmost interface, which is
 * analytic. Next-event estimation connects every vertex to wo along a path that is drawn once per
 * walk; the walk itself may also leave through the top towards wo. The power heuristic combines
 * both. A twin of Python's `reference.walk`, where the derivation is.
 */

import type { CoatOfChannel } from "../features";
import type { WalkedBottom } from "./bottoms";
import { connectionWeight, type ExitPath, exitPaths } from "./exits";
import * as rough from "./interface";
import { phase, samplePhaseCosine } from "./microfacet";
import { aboutAxis, dot, flipped, negated, type Vector } from "./vector";

/** Walks of less throughput continue with the probability throughput / this. */
const ROULETTE_THRESHOLD = 0.25;

/** The result of a vertex: its contribution to wo, and the next segment of the walk. */
interface Event {
  readonly contribution: number;
  readonly direction: Vector;
  readonly throughput: number;
  /** Density [1/sr] of the direction. */
  readonly pdf: number;
  /** Sum of squared density ratios of the techniques that connect below this vertex. */
  readonly ratios: number;
}

/** A walk through the coats of one channel. */
export class Walk {
  private w: Vector;
  private layer = 0;
  /** In the layer: 0 at its top, 1 at its bottom. */
  private depth = 0;
  private throughput: number;
  private pdf = 0;
  private ratios = 0;
  private readonly exits: readonly ExitPath[];

  private constructor(
    private readonly coats: readonly CoatOfChannel[],
    private readonly bottom: WalkedBottom,
    wi: Vector,
    private readonly wo: Vector,
    private readonly uniform: () => number,
  ) {
    const { alpha, eta } = coats[0];
    const entered = rough.sampleTransmission(wi, alpha, eta, uniform(), uniform());
    this.w = entered.direction;
    this.throughput = entered.weight;
    this.exits = exitPaths(coats, wo, uniform);
  }

  /** One walk's estimate of f(wi, wo), both above the horizon. */
  static estimate(
    coats: readonly CoatOfChannel[],
    bottom: WalkedBottom,
    wi: Vector,
    wo: Vector,
    uniform: () => number,
  ): number {
    const walk = new Walk(coats, bottom, wi, wo, uniform);
    let result = 0;
    let active = walk.throughput > 0;
    while (active) {
      const event = walk.advance();
      result += event.contribution;
      const survival = Math.min(event.throughput / ROULETTE_THRESHOLD, 1);
      walk.w = event.direction;
      walk.pdf = event.pdf;
      walk.ratios = event.ratios;
      walk.throughput = event.throughput / survival;
      active = uniform() < survival && walk.w.z !== 0; // false without throughput
    }
    return result;
  }

  /** Fly to the next vertex, connect to wo, and scatter. */
  private advance(): Event {
    const isDown = this.w.z < 0;
    const coat = this.coats[this.layer];
    const path = this.exits[this.layer];
    const isInMedium = this.fly(coat.sigmaT);
    const visible = Math.exp(-coat.sigmaT * (this.depth / path.direction.z));
    if (isInMedium) {
      return this.inMedium(coat, path, visible);
    }
    if (isDown && this.layer === this.coats.length - 1) {
      return this.atBottom(path, visible);
    }
    return !isDown && this.layer === 0 ? this.atTop() : this.atInterface(isDown);
  }

  /** Move to the next collision or boundary of the layer; returns whether it is a collision. */
  private fly(sigmaT: number): boolean {
    const { w, depth } = this;
    const toBoundary = (w.z < 0 ? 1 - depth : depth) / Math.abs(w.z);
    const flight = -Math.log(1 - this.uniform()) / sigmaT;
    const collides = flight < toBoundary;
    const distance = collides ? flight : toBoundary;
    this.depth = Math.min(Math.max(depth - w.z * distance, 0), 1);
    return collides;
  }

  /** A collision: absorption, and Henyey-Greenstein scattering. */
  private inMedium({ albedo, g }: CoatOfChannel, path: ExitPath, visible: number): Event {
    const throughput = this.throughput * albedo;
    const towards = phase(dot(this.w, path.direction), g);
    const connected = (throughput * towards * visible * path.weight) / path.direction.z;
    const cosine = samplePhaseCosine(g, this.uniform());
    return {
      contribution: connected * connectionWeight(path, towards),
      direction: aboutAxis(this.w, cosine, 2 * Math.PI * this.uniform()),
      throughput,
      pdf: phase(cosine, g),
      ratios: 0,
    };
  }

  /** The topmost interface from below: exit towards wo, then forced internal reflection. */
  private atTop(): Event {
    const { alpha, eta } = this.coats[0];
    const inward = rough.transmission(this.wo, negated(this.w), alpha, eta);
    const ratio = inward.pdf / this.pdf;
    const mis = this.pdf > 0 ? 1 / (1 + ratio * ratio * (1 + this.ratios)) : 0;
    const incident = flipped(negated(this.w));
    const [u1, u2] = [this.uniform(), this.uniform()];
    const drawn = rough.sampleReflection(incident, alpha, 1 / eta, u1, u2);
    return {
      // BTDFs in flux convention differ by eta^2 between the two directions.
      contribution: (this.throughput * inward.f * mis) / (eta * eta),
      direction: flipped(drawn.direction),
      throughput: this.throughput * drawn.weight,
      pdf: 0, // the next vertex is below: no connection uses it
      ratios: 0,
    };
  }

  private atBottom(path: ExitPath, visible: number): Event {
    const incident = negated(this.w);
    const { f, pdf } = this.bottom.value(incident, path.direction);
    const connected = this.throughput * f * visible * path.weight;
    const drawn = this.bottom.sample(incident, this.uniform(), this.uniform());
    return {
      contribution: connected * connectionWeight(path, pdf),
      direction: drawn.direction,
      throughput: this.throughput * drawn.weight,
      pdf: drawn.pdf,
      ratios: 0,
    };
  }

  /** An interface between two media, from either side. It connects along the chain above it. */
  private atInterface(isDown: boolean): Event {
    const below = isDown ? this.layer + 1 : this.layer;
    const { alpha, eta: etaBelow } = this.coats[below];
    const eta = isDown ? etaBelow : 1 / etaBelow;
    const backward = negated(this.w);
    const incident = isDown ? backward : flipped(backward);
    const path = this.exits[below - 1];
    const outgoing = isDown ? path.direction : flipped(path.direction);
    const { f, pdf } = rough.scatter(incident, outgoing, alpha, eta);
    const visible = Math.exp(-this.coats[below - 1].sigmaT / path.direction.z);
    const connected = this.throughput * f * visible * path.weight;
    const weight = connectionWeight(path, pdf, this.ratiosBelow(path.direction, alpha, etaBelow));
    const [u0, u1, u2] = [this.uniform(), this.uniform(), this.uniform()];
    const drawn = rough.sample(incident, alpha, eta, u0, u1, u2);
    const direction = isDown ? drawn.direction : flipped(drawn.direction);
    const isRising = direction.z > 0;
    this.layer = isRising ? below - 1 : below;
    this.depth = isRising ? 1 : 0;
    // Without an interface this is no vertex: the direction is the one that the last vertex drew.
    return {
      contribution: connected * weight,
      direction,
      throughput: this.throughput * drawn.weight,
      pdf: eta === 1 ? this.pdf : drawn.pdf,
      ratios: eta === 1 ? this.ratios : isRising ? this.ratiosBelow(direction, alpha, etaBelow) : 0,
    };
  }

  /** Squared ratios of connections below, for a walk that goes on upwards along `outside`. */
  private ratiosBelow(outside: Vector, alpha: number, etaBelow: number): number {
    if (this.w.z < 0 || this.pdf <= 0) {
      return 0;
    }
    const exit = rough.transmission(outside, negated(this.w), alpha, etaBelow);
    const ratio = exit.pdf / this.pdf;
    return ratio * ratio * (1 + this.ratios);
  }
}
