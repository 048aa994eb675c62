/** Textures of codes that were opened: the page's state names them only. */

import { signal } from "@preact/signals";
import { type CodeTexture, readTexture } from "../material/texture";
import { readTemplate, texelShaderText } from "../save/shader";
import type { PageCore } from "./remote";

/** A texture and the shader code that makes materials of its texels. */
export interface ShownTexture {
  texture: CodeTexture;
  shader: string;
}

export const textures = signal<ReadonlyMap<string, ShownTexture>>(new Map());

/**
 * Keep the texture of a file as long as the page lives; returns its name in the state.
 *
 * @throws Refusal if it is damaged or of other networks.
 */
export async function keepTexture(
  file: Uint8Array<ArrayBuffer>,
  networks: Pick<PageCore, "latentSize" | "fingerprint">,
): Promise<string> {
  const texture = readTexture(file, networks);
  const shader = texelShaderText(await readTemplate("glsl"), texture);
  textures.value = new Map(textures.value).set(texture.id, { texture, shader });
  return texture.id;
}
