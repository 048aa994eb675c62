import { expect, test } from "vitest";
import { blobOf, partsOf } from "../../src/engine/large_picture";
import { Refusal } from "../../src/refusal";

test.each([
  [1320, 640],
  [390, 305],
  [360, 720],
  [4000, 2000],
])(
  "a 4K picture of a canvas of %d by %d has 3840 pixels along its longer side",
  (width, height) => {
    const { count, ...part } = partsOf("4K", { width, height });
    expect(count * Math.max(part.width, part.height)).toBe(3840);
    expect(part.width).toBeLessThanOrEqual(width);
    expect(part.height).toBeLessThanOrEqual(height);
    expect(part.width / part.height / (width / height)).toBeCloseTo(1, 1);
  },
);

test("a canvas that is too large to be saved is told", async () => {
  const tooLarge = { toBlob: (callback: BlobCallback) => callback(null) } as HTMLCanvasElement;
  await expect(blobOf(tooLarge)).rejects.toThrow(Refusal);
});
