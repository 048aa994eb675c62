/** The numeric core in its worker, with the networks. */

import type { Stack } from "../core/api";
import { RemoteCore } from "../core/client";
import { isAnisotropic } from "../material/material";
import { Refusal } from "../refusal";
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
  | "walk"
>;

const WEIGHTS = "weights.safetensors";
const ANISOTROPIC_WEIGHTS = "anisotropic.safetensors";

/** The cores: one for isotropic materials, and one for others, which starts when it is needed. */
export class Cores {
  private second: Promise<PageCore> | null = null;

  constructor(
    readonly isotropic: PageCore,
    private readonly start: () => Promise<PageCore> = () => connect(ANISOTROPIC_WEIGHTS),
  ) {}

  /** @throws Refusal if it cannot be loaded. */
  anisotropic(): Promise<PageCore> {
    this.second ??= this.start();
    return this.second;
  }

  /**
   * The core of a stack.
   *
   * @throws Refusal if its codes are of isotropic networks and a coat has two widths.
   */
  async of(stack: Stack): Promise<PageCore> {
    if (!isAnisotropic(stack)) return this.isotropic;
    const { bottom } = stack;
    if (bottom.kind === "codes" && bottom.widths !== 2)
      throw new Refusal(
        "The loaded material is isotropic; give its coats one width, or coat it in Python.",
      );
    return this.anisotropic();
  }
}

/**
 * Start a worker and load networks.
 *
 * @throws Refusal if they cannot be loaded.
 */
export async function connect(path = WEIGHTS): Promise<PageCore> {
  const worker = await startWorker();
  const core = new RemoteCore(worker);
  const broken = new Promise<never>((_resolve, reject) => {
    const refusal = new Refusal(
      "The browser could not start the page's worker; load the page anew.",
    );
    worker.addEventListener("error", () => reject(refusal));
  });
  const weights = await readFile(path);
  if (weights === null) throw new Refusal(`The networks are missing beside the page (${path}).`);
  await Promise.race([core.load(weights.buffer), broken]);
  return core;
}
