/** The core behind messages, with both sides in this process. */

import { afterEach, beforeEach, describe, expect, test } from "vitest";
import { type CoreCalls, coreCalls } from "../../src/core/calls";
import { loadCore } from "../../src/core/core";
import { type Port, Remote, serve } from "../../src/core/rpc";
import { FileError } from "../../src/core/safetensors";
import { coreOf } from "../../src/engine/remote";
import { bytesOf, readVectors, SHIPPED } from "./vectors";

const vectors = readVectors("default");
const stack = vectors.stacks[8]!;
const [wi, wo] = [vectors.of("wi"), vectors.of("wo")];
const weights = () => bytesOf(SHIPPED);

let remote: Remote<CoreCalls>;
let channel: MessageChannel;

beforeEach(() => {
  channel = new MessageChannel();
  serve(coreCalls(), channel.port1 as unknown as Port);
  remote = new Remote(channel.port2 as unknown as Port);
  for (const port of [channel.port1, channel.port2]) port.start();
});

afterEach(() => channel.port1.close());

const load = () => coreOf(remote, weights());

describe("calls", { timeout: 30_000 }, () => {
  test("give what the core gives", async () => {
    const core = loadCore(weights());
    const other = await load();
    expect(other.latentSize).toBe(core.latentSize);
    const material = await other.layer(stack);
    expect(material).toEqual(core.layer(stack));
    expect(await other.f(material, wi, wo)).toEqual(core.f(material, wi, wo));
    const cosines = Float32Array.of(0.2, 0.9);
    expect(await other.albedo(material, cosines)).toEqual(core.albedo(material, cosines));
    const options = { azimuths: 1, cosines: 2, samples: 4, shift: [0, 0.5, 0] } as const;
    expect(await other.table(material, options)).toEqual(core.table(material, options));
  });

  test("fail with a sentence, and the next one is answered", async () => {
    await expect(coreOf(remote, new ArrayBuffer(3))).rejects.toThrow(FileError);
    const core = await load();
    expect((await core.layer(stack)).latents).toHaveLength(3 * core.latentSize);
  });
});
