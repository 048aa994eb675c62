/** `src/engine/remote.ts` with the stand-in core, for tests of the page without networks. */

import type { PageCore } from "../../src/engine/remote";
import { standIn } from "./core";

export type { PageCore };

export async function connect(): Promise<PageCore> {
  const core = standIn();
  return {
    latentSize: core.latentSize,
    layer: async (stack) => core.layer(stack),
    f: async (material, wi, wo) => core.f(material, wi, wo),
    albedo: async (material, cosines) => core.albedo(material, cosines),
    table: async (material, options) => core.table(material, options),
    walk: () => new Promise(() => {}),
  };
}
