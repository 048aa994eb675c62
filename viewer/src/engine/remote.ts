/** The numeric core in its worker, with the networks. */

import { RemoteCore } from "../core/client";
import { Refusal } from "../refusal";

/** What the page needs of the core. */
export type PageCore = Pick<
  RemoteCore,
  "latentSize" | "fingerprint" | "encodeMeasured" | "layer" | "f" | "albedo" | "table" | "walk"
>;

const WEIGHTS = "weights.safetensors";

/**
 * Start the worker and load the networks.
 *
 * @throws Refusal if they cannot be loaded.
 */
export async function connect(): Promise<PageCore> {
  const worker = new Worker(new URL("../core/worker.ts", import.meta.url), { type: "module" });
  const core = new RemoteCore(worker);
  const broken = new Promise<never>((_resolve, reject) => {
    const refusal = new Refusal(
      "The browser could not start the page's worker; load the page anew.",
    );
    worker.addEventListener("error", () => reject(refusal));
  });
  const answer = await fetch(WEIGHTS);
  if (!answer.ok)
    throw new Refusal(`The networks are missing beside the page (${WEIGHTS}: ${answer.status}).`);
  await Promise.race([core.load(await answer.arrayBuffer()), broken]);
  return core;
}
