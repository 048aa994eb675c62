/** The numeric core in its worker, with the networks. */

import type { Stack } from "../core/api";
import { RemoteCore } from "../core/client";
import { isAnisotropic, widthRatio } from "../material/material";
import { Cancelled, Refusal } from "../refusal";
import { readFile, startWorker } from "./files";

/** What the page needs of the core. */
export type PageCore = Pick<
  RemoteCore,
  | "latentSize"
  | "widths"
  | "fingerprint"
  | "encodeMeasured"
  | "layer"
  | "f"
  | "albedo"
  | "table"
  | "basisTexels"
  | "walk"
>;

const WEIGHTS = "weights.safetensors";
const ANISOTROPIC_WEIGHTS = "anisotropic.safetensors";

/** Largest ratio of two widths that is layered, as in Python. */
const MOST_RATIO = 10;

/** The cores: one for isotropic materials, and one for others, which starts when it is needed. */
export class Cores {
  private second: Promise<PageCore> | null = null;

  constructor(
    readonly isotropic: PageCore,
    private readonly start: () => Promise<PageCore> = () => connect(ANISOTROPIC_WEIGHTS),
  ) {}

  /** @throws Refusal if it cannot be loaded. */
  anisotropic(): Promise<PageCore> {
    this.second ??= this.start().catch((error) => {
      this.second = null; // another try may succeed
      throw error;
    });
    return this.second;
  }

  /**
   * The core of a stack.
   *
   * @throws Refusal if its codes are of isotropic networks and a coat has two widths, or widths
   *   differ too much.
   */
  async of(stack: Stack): Promise<PageCore> {
    if (!isAnisotropic(stack)) return this.isotropic;
    const { bottom, coats } = stack;
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
 * The result of a call that needs no networks, by a worker of its own.
 *
 * @throws Cancelled if `end` comes first.
 */
export async function byOwnWorker<T>(
  call: (core: RemoteCore) => Promise<T>,
  end?: AbortSignal,
): Promise<T> {
  const { worker, broken } = await startWorker();
  const ended = new Promise<never>((_resolve, reject) => {
    end?.addEventListener("abort", () => reject(new Cancelled()));
  });
  try {
    return await Promise.race([call(new RemoteCore(worker)), broken, ended]);
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
  const { worker, broken } = await startWorker();
  const core = new RemoteCore(worker);
  const load = async () => {
    const bytes = await weights;
    if (bytes === null) throw new Refusal(`The networks are missing beside the page (${path}).`);
    await core.load(bytes.buffer);
  };
  await Promise.race([load(), broken]);
  return core;
}
