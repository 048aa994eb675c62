/** The core in a worker. */

import { loadCore, METHODS, type NetworkCore, type Networks } from "./core";
import { serve } from "./rpc";

export type CoreCalls = Pick<NetworkCore, (typeof METHODS)[number]> & {
  /** Load the networks, which all other calls need. */
  load(weights: ArrayBuffer): Networks;
};

let core: NetworkCore;

const method = (name: (typeof METHODS)[number]) => {
  return (...args: never[]) => (core[name] as (...args: never[]) => unknown)(...args);
};

serve({
  ...Object.fromEntries(METHODS.map((name) => [name, method(name)])),
  load(weights: ArrayBuffer): Networks {
    core = loadCore(weights);
    const { latentSize, widths, fingerprint } = core;
    return { latentSize, widths, fingerprint };
  },
});
