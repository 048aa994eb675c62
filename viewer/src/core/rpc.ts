/** Calls of functions in a worker by messages, answered in their order. */

import { FileError } from "./safetensors";

type Call = { id: number; name: string; args: unknown[] };

type Answer = { id: number } & ({ result: unknown } | { error: { name: string; message: string } });

/** A worker, or its side of the messages. */
interface Port {
  postMessage(message: unknown, transfer: Transferable[]): void;
  addEventListener(type: "message", listener: (event: { data: never }) => void): void;
}

/** Answer the calls that arrive at this worker, by the names of functions. */
export function serve(functions: Record<string, (...args: never[]) => unknown>): void {
  const port = self as unknown as Port;
  port.addEventListener("message", async ({ data: { id, name, args } }: { data: Call }) => {
    try {
      const result = await (functions[name] as (...args: unknown[]) => unknown)(...args);
      port.postMessage({ id, result }, buffersOf(result));
    } catch (error) {
      const { name, message } = error instanceof Error ? error : new Error(String(error));
      port.postMessage({ id, error: { name, message } }, []);
    }
  });
}

/** The buffers of a value that is an array or has arrays, which are given away and not copied. */
function buffersOf(value: unknown): ArrayBuffer[] {
  const fields = ArrayBuffer.isView(value) ? [value] : Object.values(Object(value));
  const buffers = fields.map((field) => ArrayBuffer.isView(field) && field.buffer);
  return [...new Set(buffers.filter((buffer) => buffer instanceof ArrayBuffer))];
}

interface Promised {
  resolve(result: never): void;
  reject(error: Error): void;
}

/** The functions of a worker. */
export class Remote<All extends { [Name in keyof All]: (...args: never[]) => unknown }> {
  private readonly promised = new Map<number, Promised>();
  private count = 0;

  constructor(private readonly port: Port) {
    port.addEventListener("message", ({ data }: { data: Answer }) => {
      const promised = this.promised.get(data.id);
      this.promised.delete(data.id);
      if ("result" in data) return promised?.resolve(data.result as never);
      const { name, message } = data.error;
      promised?.reject(name === "FileError" ? new FileError(message) : new Error(message));
    });
  }

  /** @param transfer what is given away and not copied. */
  call<Name extends keyof All & string>(
    name: Name,
    args: Parameters<All[Name]>,
    transfer: Transferable[] = [],
  ): Promise<Awaited<ReturnType<All[Name]>>> {
    const id = this.count++;
    return new Promise((resolve, reject) => {
      this.promised.set(id, { resolve, reject });
      this.port.postMessage({ id, name, args }, transfer);
    });
  }
}
