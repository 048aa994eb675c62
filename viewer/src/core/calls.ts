/** What the core's worker does, by name. */

import type { Stack } from "./api";
import { loadCore, type NetworkCore } from "./core";
import type { Context } from "./rpc";
import { type Estimate, Reference } from "./walk/reference";

/** Milliseconds of walks after which calls that wait are answered, and between two estimates. */
const SLICE = 24;
const REPORT_INTERVAL = 120;

/** How long and by which numbers to walk. */
export interface WalkOptions {
  /** The same seed gives the same numbers. */
  readonly seed: number;
  /** Walks of every pair and channel at most. */
  readonly walks: number;
}

/** Methods of the core that a worker has. */
const METHODS = ["encodeMeasured", "layer", "f", "albedo", "table", "basisTexels"] as const;

export interface CoreCalls extends Pick<NetworkCore, (typeof METHODS)[number]> {
  /** Load the networks, which the methods of the core need. */
  load(weights: ArrayBuffer): Pick<NetworkCore, "latentSize" | "widths" | "fingerprint">;
  /**
   * Estimate f of a stack by random walks in the time that other calls leave; another walk ends it.
   */
  walk(
    stack: Stack,
    wi: Float32Array,
    wo: Float32Array,
    options: WalkOptions,
    context: Context,
  ): Promise<Estimate>;
}

/** The functions of a worker. @param pause resolves after the calls that have arrived. */
export function coreCalls(pause: () => Promise<void>): CoreCalls {
  let core: NetworkCore | undefined;
  let latest: Reference | undefined;
  const method = (name: (typeof METHODS)[number]) => {
    return (...args: never[]) => {
      if (core === undefined) throw new Error("the networks are not loaded yet");
      return (core[name] as (...args: never[]) => unknown)(...args);
    };
  };
  const methods = Object.fromEntries(METHODS.map((name) => [name, method(name)]));
  return {
    ...(methods as unknown as Pick<NetworkCore, (typeof METHODS)[number]>),
    load(weights) {
      core = loadCore(weights);
      const { latentSize, widths, fingerprint } = core;
      return { latentSize, widths, fingerprint };
    },
    async walk(stack, wi, wo, { seed, walks }, { told, signal }) {
      const reference = new Reference(stack, wi, wo, seed);
      latest = reference;
      let reported = performance.now();
      for (let done = 0; done < walks; ) {
        await pause();
        if (signal.aborted || latest !== reference) break;
        const start = performance.now();
        for (; done < walks && performance.now() < start + SLICE; done++) reference.add(1);
        if (done < 2 || performance.now() < reported + REPORT_INTERVAL) continue;
        reported = performance.now();
        told(reference.estimate());
      }
      return reference.estimate();
    },
  };
}
