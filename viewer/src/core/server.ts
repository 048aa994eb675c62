/** The worker's side: calls in their order, and walks while there is nothing else to do. */

import { readMesh } from "../picture/mesh_files";
import { loadCore, type NetworkCore } from "./core";
import { readExr } from "./exr_file";
import { occlusion } from "./occlusion";
import type { CallName, Calls, Cancellation, Request, Response } from "./protocol";
import { Reference } from "./walk/reference";

/** Milliseconds of walks after which waiting calls are looked at, and between two estimates. */
const SLICE = 24;
const REPORT_INTERVAL = 120;

/** What the server needs of a worker. */
export interface Surroundings {
  post(response: Response, transfer: ArrayBuffer[]): void;
  /** Run a task after messages that have arrived. */
  defer(task: () => void): void;
}

type WalkRequest = Extract<Request, { call: "walk" }>;

/** A walk that goes on. */
interface Walker {
  readonly request: WalkRequest;
  readonly reference: Reference;
  walks: number;
  reported: number;
}

export class Server {
  private core: NetworkCore | undefined;
  private waiting: Request[] = [];
  private walker: Walker | undefined;
  private isDeferred = false;

  constructor(private readonly surroundings: Surroundings) {}

  /** Take a message of the page. */
  receive(message: Request | Cancellation): void {
    if ("cancelled" in message) {
      this.drop((request) => request.id === message.cancelled);
    } else {
      if (message.call === "walk") this.drop((request) => request.call === "walk");
      this.waiting.push(message);
    }
    this.defer();
  }

  /** Answer walks that are not wanted any more. */
  private drop(isUnwanted: (request: Request) => boolean): void {
    const dropped = this.waiting.filter(isUnwanted);
    this.waiting = this.waiting.filter((request) => !dropped.includes(request));
    if (this.walker && isUnwanted(this.walker.request)) {
      dropped.push(this.walker.request);
      this.walker = undefined;
    }
    for (const { id } of dropped) this.post({ id, superseded: true });
  }

  private defer(): void {
    if (!this.isDeferred) {
      this.isDeferred = true;
      this.surroundings.defer(() => {
        this.isDeferred = false;
        if (this.work()) {
          this.defer();
        }
      });
    }
  }

  /** Do one piece of work; returns whether there may be more. */
  private work(): boolean {
    const request = this.waiting.shift();
    if (request) {
      this.guarded(request.id, () => this.answer(request));
    } else if (this.walker) {
      const { walker } = this;
      this.guarded(walker.request.id, () => this.walk(walker));
    } else {
      return false;
    }
    return true;
  }

  private guarded(id: number, task: () => void): void {
    try {
      task();
    } catch (error) {
      const { name, message } = error instanceof Error ? error : new Error(String(error));
      this.post({ id, error: { name, message } });
      this.walker = this.walker?.request.id === id ? undefined : this.walker;
    }
  }

  private answer(request: Request): void {
    if (request.call === "walk") {
      const [stack, wi, wo, { seed }] = request.args;
      const reference = new Reference(stack, wi, wo, seed);
      this.walker = { request, reference, walks: 0, reported: performance.now() };
      return;
    }
    this.post({ id: request.id, result: this.result(request) });
  }

  private result(request: Exclude<Request, WalkRequest>): ReturnType<Calls[CallName]> {
    if (request.call === "load") {
      this.core = loadCore(...request.args);
      const { latentSize, widths, fingerprint } = this.core;
      return { latentSize, widths, fingerprint };
    }
    if (request.call === "occlusion") return occlusion(...request.args);
    if (request.call === "readExr") return readExr(...request.args);
    if (request.call === "readMesh")
      return readMesh(...request.args, (soFar) => this.post({ id: request.id, soFar }));
    if (!this.core) {
      throw new Error("the networks are not loaded yet");
    }
    const method = this.core[request.call] as (...args: unknown[]) => ReturnType<Calls[CallName]>;
    return method.apply(this.core, request.args);
  }

  private walk(walker: Walker): void {
    const { request, reference } = walker;
    const [, , , { walks }] = request.args;
    const start = performance.now();
    while (walker.walks < walks && performance.now() < start + SLICE) {
      reference.add(1);
      walker.walks++;
    }
    if (walker.walks >= walks) {
      this.walker = undefined;
      this.post({ id: request.id, result: reference.estimate() });
    } else if (walker.walks > 1 && performance.now() > walker.reported + REPORT_INTERVAL) {
      walker.reported = performance.now();
      this.post({ id: request.id, soFar: reference.estimate() });
    }
  }

  private post(response: Response): void {
    this.surroundings.post(response, buffersOf(response));
  }
}

/** The buffers of a response's arrays, which are given away and not copied. */
function buffersOf(response: Response): ArrayBuffer[] {
  const value = "result" in response ? response.result : "soFar" in response ? response.soFar : {};
  const arrays = ArrayBuffer.isView(value) ? [value] : Object.values(value);
  const buffers = arrays.flatMap((array: unknown) =>
    ArrayBuffer.isView(array) && array.buffer instanceof ArrayBuffer ? [array.buffer] : [],
  );
  return [...new Set(buffers)];
}
