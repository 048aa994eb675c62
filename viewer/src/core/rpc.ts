/** Calls of functions in a worker by messages, answered in their order. */

import { Cancelled } from "../refusal";
import { FileError } from "./safetensors";

/** What a function is given behind its arguments. */
export interface Context {
  /** Post what is known so far. */
  told(soFar: unknown): void;
  /** Aborted when the caller does not want the result any more. */
  readonly signal: AbortSignal;
}

/** Functions by name; asynchronous ones leave time for others. */
type Functions = Record<string, (...args: never[]) => unknown>;

type Call = { id: number; name: string; args: unknown[] } | { cancelled: number };

type Answer = { id: number } & (
  | { result: unknown }
  | { soFar: unknown }
  | { error: { name: string; message: string } }
);

/** A worker, or its side of the messages. */
export interface Port {
  postMessage(message: unknown, transfer: Transferable[]): void;
  addEventListener(type: "message", listener: (event: { data: never }) => void): void;
}

/** Answer the calls that arrive at a port, or at this worker. */
export function serve(functions: Functions, port = self as unknown as Port): void {
  const ends = new Map<number, AbortController>();
  const answer = (id: number, kind: "result" | "soFar" | "error", value: unknown) =>
    port.postMessage({ id, [kind]: value }, buffersOf(value));
  port.addEventListener("message", async ({ data }: { data: Call }) => {
    if ("cancelled" in data) return ends.get(data.cancelled)?.abort();
    const { id, name, args } = data;
    const end = new AbortController();
    ends.set(id, end);
    const told = (soFar: unknown) => answer(id, "soFar", soFar);
    const context: Context = { told, signal: end.signal };
    try {
      const called = functions[name] as (...args: unknown[]) => unknown;
      answer(id, "result", await called(...args, context));
    } catch (error) {
      const { name, message } = error instanceof Error ? error : new Error(String(error));
      answer(id, "error", { name, message });
    }
    ends.delete(id);
  });
}

/** The buffers of a value that is an array or has arrays, which are given away and not copied. */
function buffersOf(value: unknown): ArrayBuffer[] {
  const fields = ArrayBuffer.isView(value) ? [value] : Object.values(Object(value));
  const buffers = fields.map((field) => ArrayBuffer.isView(field) && field.buffer);
  return [...new Set(buffers.filter((buffer) => buffer instanceof ArrayBuffer))];
}

/** What a call may have besides its arguments. */
interface Options<SoFar> {
  /** What is given away and not copied. */
  transfer?: Transferable[];
  /** Called with what is known before the result. */
  told?: ((soFar: SoFar) => void) | undefined;
  /** Ends the call, which then fails with `Cancelled`. */
  signal?: AbortSignal | undefined;
}

interface Promised {
  resolve(result: unknown): void;
  reject(error: Error): void;
  told?: ((soFar: never) => void) | undefined;
}

/** The arguments of a function without the context. */
type Args<F> = F extends (...args: infer All) => unknown
  ? All extends [...infer Own, Context]
    ? Own
    : All
  : never;

/** The functions of a worker. */
export class Remote<All extends { [Name in keyof All]: (...args: never[]) => unknown }> {
  private readonly promised = new Map<number, Promised>();
  private count = 0;

  constructor(private readonly port: Port) {
    port.addEventListener("message", ({ data }: { data: Answer }) => {
      const promised = this.promised.get(data.id);
      if ("soFar" in data) return promised?.told?.(data.soFar as never);
      this.promised.delete(data.id);
      if ("result" in data) return promised?.resolve(data.result);
      const { name, message } = data.error;
      promised?.reject(name === "FileError" ? new FileError(message) : new Error(message));
    });
  }

  call<Name extends keyof All & string, SoFar = never>(
    name: Name,
    args: Args<All[Name]>,
    { transfer = [], told, signal }: Options<SoFar> = {},
  ): Promise<Awaited<ReturnType<All[Name]>>> {
    const id = this.count++;
    return new Promise((resolve, reject) => {
      if (signal?.aborted) return reject(new Cancelled());
      signal?.addEventListener("abort", () => {
        if (!this.promised.delete(id)) return;
        this.port.postMessage({ cancelled: id }, []);
        reject(new Cancelled());
      });
      this.promised.set(id, { resolve: resolve as Promised["resolve"], reject, told });
      this.port.postMessage({ id, name, args }, transfer);
    });
  }
}
