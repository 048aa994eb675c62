/** The page's side of the core in its worker. */

import type { Core, Stack } from "./api";
import type {
  CallName,
  Calls,
  Cancellation,
  Request,
  Response,
  SoFar,
  WalkOptions,
} from "./protocol";
import { FileError } from "./safetensors";
import type { Estimate } from "./walk/reference";

/** A worker, or whatever passes messages to one. */
export interface Port {
  postMessage(message: Request | Cancellation, transfer: Transferable[]): void;
  addEventListener(type: "message", listener: (event: { data: Response }) => void): void;
}

/** A later walk has taken the place of this one, or it was cancelled. */
export class Superseded extends Error {
  constructor() {
    super("a later request has taken the place of this one");
  }
}

interface Promised {
  resolve(result: ReturnType<Calls[CallName]>): void;
  reject(error: Error): void;
  soFar: ((soFar: SoFar) => void) | undefined;
}

/** The core behind messages, the methods of `Core`. Calls are answered in their order. */
export class RemoteCore {
  private readonly promised = new Map<number, Promised>();
  private count = 0;
  private loaded: ReturnType<Calls["load"]> = { latentSize: 0, widths: 1, fingerprint: "" };

  readonly layer = this.remote("layer");
  readonly f = this.remote("f");
  readonly albedo = this.remote("albedo");
  readonly table = this.remote("table");
  readonly basisTexels = this.remote("basisTexels");
  readonly occlusion = this.remote("occlusion");
  readonly readExr = this.remote("readExr");

  /** @param port a worker of `worker.ts`; without `load`, it reads files, walks, and knows what a mesh hides. */
  constructor(private readonly port: Port) {
    port.addEventListener("message", ({ data }) => this.receive(data));
  }

  /** Numbers of one channel's code; 0 before the networks are loaded. */
  get latentSize(): number {
    return this.loaded.latentSize;
  }

  /** GGX widths of a surface; 1 before the networks are loaded. */
  get widths(): Core["widths"] {
    return this.loaded.widths;
  }

  /** Identifies the networks; "" before they are loaded. */
  get fingerprint(): string {
    return this.loaded.fingerprint;
  }

  /**
   * Load the networks. The weights are given away.
   *
   * @throws FileError if the file is damaged.
   */
  async load(weights: ArrayBuffer): Promise<void> {
    this.loaded = await this.call("load", [weights], [weights]);
  }

  /**
   * Encode a measured BRDF. The file is given away.
   *
   * @throws FileError if it is damaged or of another format.
   */
  encodeMeasured(file: ArrayBuffer): ReturnType<typeof this.layer> {
    return this.call("encodeMeasured", [file], [file]);
  }

  /**
   * Estimate f of a stack by random walks, in the time that other calls leave.
   *
   * A worker walks for one call at a time: another walk supersedes it.
   *
   * @param soFar is called several times a second with what is known.
   * @param signal ends the walk, whose promise then fails with `Superseded`.
   */
  walk(
    stack: Stack,
    pairs: readonly [wi: Float32Array, wo: Float32Array],
    options: WalkOptions,
    soFar: (estimate: Estimate) => void,
    signal?: AbortSignal,
  ): Promise<Estimate> {
    if (signal?.aborted) return Promise.reject(new Superseded());
    const id = this.count;
    signal?.addEventListener("abort", () => this.port.postMessage({ cancelled: id }, []));
    const told = (estimate: SoFar) => soFar(estimate as Estimate);
    return this.call("walk", [stack, ...pairs, options], [], told);
  }

  /**
   * Read a mesh from the bytes of a file, which are moved to the worker; see `readMesh`.
   *
   * @param told is called with the progress, from 0 to 1.
   */
  readMesh(bytes: Uint8Array<ArrayBuffer>, suffix: string, told: (share: number) => void) {
    return this.call("readMesh", [bytes, suffix], [bytes.buffer], (soFar) => told(soFar as number));
  }

  /** A method of the core by its name. */
  private remote<Name extends CallName>(name: Name) {
    return (...args: Parameters<Calls[Name]>) => this.call(name, args);
  }

  private call<Name extends CallName>(
    call: Name,
    args: Parameters<Calls[Name]>,
    transfer: Transferable[] = [],
    soFar?: Promised["soFar"],
  ): Promise<ReturnType<Calls[Name]>> {
    const id = this.count++;
    return new Promise((resolve, reject) => {
      this.promised.set(id, { resolve: resolve as Promised["resolve"], reject, soFar });
      this.port.postMessage({ id, call, args } as Request, transfer);
    });
  }

  private receive(response: Response): void {
    const promised = this.promised.get(response.id);
    if ("soFar" in response) {
      promised?.soFar?.(response.soFar);
      return;
    }
    this.promised.delete(response.id);
    if ("result" in response) {
      promised?.resolve(response.result);
    } else if ("superseded" in response) {
      promised?.reject(new Superseded());
    } else {
      const { name, message } = response.error;
      promised?.reject(name === "FileError" ? new FileError(message) : new Error(message));
    }
  }
}
