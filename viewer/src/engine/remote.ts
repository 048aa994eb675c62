/** The numeric core in its worker. */

import type { Material, Stack, TableOptions } from "../core/api";

/** `Core` behind messages. */
export interface RemoteCore {
  readonly latentSize: number;
  layer(stack: Stack): Promise<Material>;
  f(material: Material, wi: Float32Array, wo: Float32Array): Promise<Float32Array>;
  albedo(material: Material, cosines: Float32Array): Promise<Float32Array>;
  table(material: Material, options: TableOptions): Promise<Float32Array>;
}

/** Load the networks. */
export async function connect(): Promise<RemoteCore> {
  throw new Error("The numeric core is not connected yet.");
}
