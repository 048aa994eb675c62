/** Messages between the page and the core in its worker. */

import type { Mesh } from "../picture/meshes";
import type { Core, Stack } from "./api";
import type { readExr } from "./exr_file";
import type { occlusion } from "./occlusion";
import type { Estimate } from "./walk/reference";

/** How long and by which numbers to walk. */
export interface WalkOptions {
  /** The same seed gives the same numbers. */
  readonly seed: number;
  /** Walks of every pair and channel at most. */
  readonly walks: number;
}

/** What the worker does, by name. */
export interface Calls
  extends Pick<Core, "encodeMeasured" | "layer" | "f" | "albedo" | "table" | "basisTexels"> {
  /** Load the networks, which calls above need. */
  load(weights: ArrayBuffer): Pick<Core, "latentSize" | "widths" | "fingerprint">;
  /** `occlusion` of a mesh, which needs no networks. */
  occlusion: typeof occlusion;
  readExr: typeof readExr;
  /** `readMesh`; shares of the file that have been read precede the result. */
  readMesh(bytes: Uint8Array, suffix: string): Mesh;
  /** Estimate f of a stack by random walks; estimates so far precede the result. */
  walk(stack: Stack, wi: Float32Array, wo: Float32Array, options: WalkOptions): Estimate;
}

export type CallName = keyof Calls;

/** What precedes a result: an estimate of a walk, or the share of a file that has been read. */
export type SoFar = Estimate | number;

/** A call. Its number is its own. */
export type Request = {
  [Name in CallName]: {
    readonly id: number;
    readonly call: Name;
    readonly args: Parameters<Calls[Name]>;
  };
}[CallName];

/** The end of a walk that nobody wants any more. */
export interface Cancellation {
  readonly cancelled: number;
}

/** An answer to the call of this number. The last one has no `soFar`. */
export type Response = { readonly id: number } & (
  | { readonly result: ReturnType<Calls[CallName]> }
  | { readonly soFar: SoFar }
  | { readonly error: { readonly name: string; readonly message: string } }
  | { readonly superseded: true }
);
