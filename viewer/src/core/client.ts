/** The page's side of the core in its worker. */

import type { Bottom, Material, Stack, TableOptions } from "./api";
import type { Widths } from "./features";
import type { CallName, Calls, Cancellation, Request, Response, WalkOptions } from "./protocol";
import { FileError } from "./safetensors";
import type { Estimate } from "./walk/reference";

/** A worker, or whatever passes messages to one. */
export interface Port {
  postMessage(message: Request | Cancellation, transfer: Transferable[]): void;
  addEventListener(type: "message", listener: (event: { data: Response }) => void): void;
}

/** A later call of the same key has taken the place of this one, or it was cancelled. */
export class Superseded extends Error {
  constructor() {
    super("a later request has taken the place of this one");
  }
}

interface Promised {
  resolve(result: ReturnType<Calls[CallName]>): void;
  reject(error: Error): void;
  soFar?: ((estimate: Estimate) => void) | undefined;
}

/** The core behind messages. Calls are answered in their order; a key as in `Request`. */
export class RemoteCore {
  private readonly promised = new Map<number, Promised>();
  private count = 0;
  private size = 0;
  private networks = "";
  private ownWidths = 1 as Widths;

  /** @param port a worker of `worker.ts`; without `load`, it can only walk. */
  constructor(private readonly port: Port) {
    port.addEventListener("message", ({ data }) => this.receive(data));
  }

  /** Numbers of one channel's code; 0 before the networks are loaded. */
  get latentSize(): number {
    return this.size;
  }

  /** GGX widths of a surface; 1 before the networks are loaded. */
  get widths(): Widths {
    return this.ownWidths;
  }

  /** Identifies the networks; "" before they are loaded. */
  get fingerprint(): string {
    return this.networks;
  }

  /**
   * Load the networks. The weights are given away.
   *
   * @throws FileError if the file is damaged.
   */
  async load(weights: ArrayBuffer): Promise<void> {
    const loaded = await this.call("load", [weights], { transfer: [weights] });
    this.size = loaded.latentSize;
    this.networks = loaded.fingerprint;
    this.ownWidths = loaded.widths;
  }

  encode(bottom: Bottom, key?: string): Promise<Material> {
    return this.call("encode", [bottom], { key });
  }

  /**
   * Encode a measured BRDF. The file is given away.
   *
   * @throws FileError if it is damaged or of another format.
   */
  encodeMeasured(file: ArrayBuffer): Promise<Material> {
    return this.call("encodeMeasured", [file], { transfer: [file] });
  }

  layer(stack: Stack, key?: string): Promise<Material> {
    return this.call("layer", [stack], { key });
  }

  f(material: Material, wi: Float32Array, wo: Float32Array, key?: string): Promise<Float32Array> {
    return this.call("f", [material, wi, wo], { key });
  }

  pdf(material: Material, wi: Float32Array, wo: Float32Array, key?: string): Promise<Float32Array> {
    return this.call("pdf", [material, wi, wo], { key });
  }

  albedo(material: Material, cosines: Float32Array, key?: string): Promise<Float32Array> {
    return this.call("albedo", [material, cosines], { key });
  }

  table(material: Material, options: TableOptions, key?: string): Promise<Float32Array> {
    return this.call("table", [material, options], { key });
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
    if (signal?.aborted) {
      return Promise.reject(new Superseded());
    }
    const id = this.count;
    signal?.addEventListener("abort", () => this.port.postMessage({ cancelled: id }, []));
    return this.call("walk", [stack, ...pairs, options], { key: "walk", soFar });
  }

  private call<Name extends CallName>(
    call: Name,
    args: Parameters<Calls[Name]>,
    options: { key?: string | undefined; soFar?: Promised["soFar"]; transfer?: Transferable[] },
  ): Promise<ReturnType<Calls[Name]>> {
    const id = this.count++;
    const { key, soFar, transfer = [] } = options;
    return new Promise((resolve, reject) => {
      const settle = resolve as Promised["resolve"];
      this.promised.set(id, { resolve: settle, reject, soFar });
      this.port.postMessage({ id, call, args, key } as Request, transfer);
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
