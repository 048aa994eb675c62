import { expect, test } from "vitest";
import { openFiles } from "../../src/engine/open";
import { notice } from "../../src/state/store";

/** A file that is larger than a browser can read. */
class HugeFile extends File {
  override async arrayBuffer(): Promise<ArrayBuffer> {
    throw new DOMException("", "NotReadableError");
  }
}

test("a huge file is refused by its name, without being read", async () => {
  await openFiles([new HugeFile(["film"], "film.mp4")]);
  expect(notice.value?.text).toMatch(/^“film.mp4” was not opened. The page opens materials/);
  await openFiles([new HugeFile(["mesh"], "mesh.obj")]);
  expect(notice.value?.text).toMatch(/the browser cannot read it/);
});
