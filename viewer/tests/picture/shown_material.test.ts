import { expect, test } from "vitest";
import type { CodeTexture } from "../../src/material/texture";
import { contextOf, type Gl } from "../../src/picture/gl";
import { ShownMaterial } from "../../src/picture/shown_material";
import { Refusal } from "../../src/refusal";

/** A graphics context that takes textures of 16 texels a side, and compiles nothing. */
const answers: Record<string, unknown> = { getParameter: 16, isContextLost: true };
const gl = new Proxy({} as Gl, { get: (_, name) => () => answers[String(name)] ?? null });

const textureOf = (side: number) => ({
  texture: {
    size: [side, side],
    texels: new Uint8Array(4 * side * side),
    texelBytes: 4,
    usedBytes: 4,
    wrap: "repeat",
  } as unknown as CodeTexture,
  shader: "",
  basis: new Float32Array(),
});

test("a texture that is too large is refused, and the one before it is not drawn any more", () => {
  const material = new ShownMaterial(gl);
  material.setTexels(textureOf(16));
  expect(material.texels).not.toBe(null);
  expect(() => material.setTexels(textureOf(17))).toThrow(Refusal);
  expect(material.texels).toBe(null);
});

test("a graphics driver that lacks what is needed is told as it is", () => {
  const canvas = { getContext: () => null } as unknown as HTMLCanvasElement;
  expect(() => contextOf(canvas)).toThrow(Refusal);
});
