/** The numeric core in its worker, with the networks, and a worker for files. */

import type { Stack } from "../core/api";
import { METHODS, type NetworkCore, type Networks } from "../core/core";
import type { FTable } from "../core/f_table";
import { Remote } from "../core/rpc";
import type { CoreCalls } from "../core/worker";
import { isAnisotropic, widthRatio } from "../material/material";
import type { FileCalls } from "../picture/files";
import { Cancelled, Refusal } from "../refusal";
import { readFile, startWorker } from "./files";

/** The core behind messages: its methods are asynchronous. */
export type PageCore = Networks & {
  [Name in (typeof METHODS)[number]]: (
    ...args: Parameters<NetworkCore[Name]>
  ) => Promise<ReturnType<NetworkCore[Name]>>;
};

const WEIGHTS = "weights.safetensors";
const ANISOTROPIC_WEIGHTS = "anisotropic.safetensors";

/** Largest ratio of two widths that is layered, as in Python. */
const MOST_RATIO = 10;

/** What is made once, when it is first asked for; after a failure another try may succeed. */
export function once<T>(make: () => Promise<T>): () => Promise<T> {
  let made: Promise<T> | null = null;
  return () => {
    made ??= make().catch((error) => {
      made = null;
      throw error;
    });
    return made;
  };
}

/** The cores: one for isotropic materials, and one for others, which starts when it is needed. */
export class Cores {
  /** @throws Refusal if it cannot be loaded. */
  readonly anisotropic = once(() => connect(ANISOTROPIC_WEIGHTS));

  constructor(readonly isotropic: PageCore) {}

  /**
   * What is shown of a stack, which may have a table of its own, and its core.
   *
   * @throws Refusal if its codes are of isotropic networks and a coat has two widths, or widths
   *   differ too much.
   */
  async material({ stack, table }: { stack: Stack; table?: FTable | undefined }) {
    const core = isAnisotropic(stack) ? await this.anisotropicFor(stack) : this.isotropic;
    const layered = await core.layer(stack);
    return { core, material: { ...layered, table: table ?? layered.table } };
  }

  private anisotropicFor({ bottom, coats }: Stack): Promise<PageCore> {
    if (coats.length > 0 && [bottom, ...coats].some((one) => widthRatio(one) > MOST_RATIO))
      throw new Refusal(
        `The two widths of a surface differ by more than a factor of ${MOST_RATIO}, which the networks cannot layer; give closer widths.`,
      );
    if (bottom.kind === "codes" && bottom.widths !== 2)
      throw new Refusal(
        "The loaded material is isotropic; give its coats one width, or coat it in Python.",
      );
    return this.anisotropic();
  }
}

/**
 * The result of a call that needs no networks, by a worker of its own, which `end` stops.
 *
 * @param transfer what is given away and not copied.
 */
export async function byOwnWorker<Name extends keyof FileCalls>(
  name: Name,
  args: Parameters<FileCalls[Name]>,
  transfer: Transferable[] = [],
  end?: AbortSignal,
): Promise<Awaited<ReturnType<FileCalls[Name]>>> {
  const { worker, broken } = await startWorker("files");
  const ended = new Promise<never>((_resolve, reject) => {
    end?.addEventListener("abort", () => reject(new Cancelled()));
  });
  try {
    if (end?.aborted) throw new Cancelled();
    const result = new Remote<FileCalls>(worker).call(name, args, transfer);
    return await Promise.race([result, broken, ended]);
  } finally {
    worker.terminate();
  }
}

/**
 * Start a worker and load networks.
 *
 * @throws Refusal if they cannot be loaded.
 */
export async function connect(path = WEIGHTS): Promise<PageCore> {
  const weights = readFile(path); // while the worker starts
  const { worker, broken } = await startWorker("core");
  const remote = new Remote<CoreCalls>(worker);
  const load = async () => {
    const bytes = await weights;
    if (bytes === null) throw new Refusal(`The networks are missing beside the page (${path}).`);
    const methods = METHODS.map((name) => [name, (...args: never) => remote.call(name, args)]);
    const networks = await remote.call("load", [bytes.buffer], [bytes.buffer]);
    return { ...(Object.fromEntries(methods) as PageCore), ...networks };
  };
  try {
    return await Promise.race([load(), broken]);
  } catch (error) {
    worker.terminate();
    throw error;
  }
}
