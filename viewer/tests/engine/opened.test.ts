import { expect, test, vi } from "vitest";
import {
  meshOfState,
  occlusionOf,
  panoramaOf,
  useEnvironment,
  useMesh,
} from "../../src/engine/opened";
import { meshOf } from "../../src/picture/meshes";
import { Unreachable } from "../../src/refusal";
import { toJson } from "../../src/state/address";
import { readState } from "../../src/state/read";
import { state } from "../../src/state/store";

/** The first of all workers does not start; the others answer at once. */
class FakeWorker extends EventTarget {
  static count = 0;
  readonly terminate = () => {};

  constructor() {
    super();
    if (++FakeWorker.count === 1) queueMicrotask(() => this.dispatchEvent(new Event("error")));
  }

  postMessage({ id, name }: { id: number; name: string }): void {
    if (FakeWorker.count > 1)
      this.dispatchEvent(new MessageEvent("message", { data: { id, result: name } }));
  }
}

test("a state that was saved finds opened files by their names, however long these are", () => {
  const mesh = meshOf("ball");
  const picture = { width: 2, height: 1, pixels: new Float32Array(6) };
  const panorama = { file: new File([], ""), panorama: picture, lights: [] };
  const long = `${"a chair ".repeat(12)}.file`;
  useMesh(long, mesh);
  useEnvironment(long, panorama);
  const saved = readState(JSON.parse(toJson(state.value)));
  expect(meshOfState(saved)).toEqual({ mesh, isMissing: false });
  expect(panoramaOf(saved)).toBe(panorama);
});

test("the light that a mesh hides is computed once, and again after a failure", async () => {
  const mesh = meshOf("ball");
  vi.stubGlobal("Worker", FakeWorker);
  vi.stubGlobal("document", { getElementById: () => null });
  await expect(occlusionOf(mesh)).rejects.toThrow(Unreachable);
  expect(await Promise.all([occlusionOf(mesh), occlusionOf(mesh)])).toEqual(
    Array(2).fill("occlusion"),
  );
  expect(FakeWorker.count).toBe(2);
  vi.unstubAllGlobals();
});
