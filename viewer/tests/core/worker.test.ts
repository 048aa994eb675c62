/** The core behind messages, with both sides in this process. */

import { afterEach, beforeEach, describe, expect, test } from "vitest";
import type { Stack } from "../../src/core/api";
import { type CoreCalls, coreCalls, type WalkOptions } from "../../src/core/calls";
import { loadCore } from "../../src/core/core";
import { type Port, Remote, serve } from "../../src/core/rpc";
import { FileError } from "../../src/core/safetensors";
import type { Estimate } from "../../src/core/walk/reference";
import { coreOf } from "../../src/engine/remote";
import { Cancelled } from "../../src/refusal";
import { bytesOf, readVectors, SHIPPED } from "./vectors";

const vectors = readVectors("default");
const stacks = vectors?.stacks ?? [];
const stack = stacks[8] as Stack;
const wi = vectors?.of("wi") ?? new Float32Array();
const wo = vectors?.of("wo") ?? new Float32Array();
const weights = () => bytesOf(SHIPPED);

let remote: Remote<CoreCalls>;
let channel: MessageChannel;

beforeEach(() => {
  channel = new MessageChannel();
  const pause = () => new Promise<void>((resolve) => setTimeout(resolve));
  serve({ ...coreCalls(pause) }, channel.port1 as unknown as Port);
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
    const options = { cosines: 2, samples: 4, shift: [0, 0.5, 0] } as const;
    expect(await other.table(material, options)).toEqual(core.table(material, options));
  });

  test("fail with a sentence, and the next one is answered", async () => {
    const layer = remote.call("layer", [stack]);
    await expect(layer).rejects.toThrow("the networks are not loaded yet");
    await expect(coreOf(remote, new ArrayBuffer(3))).rejects.toThrow(FileError);
    const core = await load();
    expect((await core.layer(stack)).latents).toHaveLength(3 * core.latentSize);
  });
});

describe("a walk", { timeout: 30_000 }, () => {
  const [ways, others] = [wi.slice(0, 30), wo.slice(0, 30)];
  const endless = { seed: 2, walks: 1e9 };
  const walkOf = (options: WalkOptions) => remote.call("walk", [stack, ways, others, options]);

  test("needs no networks, and ends with the walks asked for", async () => {
    const estimate = await walkOf({ seed: 1, walks: 20 });
    expect(estimate.walks).toBe(20);
    expect(estimate.f).toHaveLength(30);
  });

  test("tells what it knows, leaves time for calls, and can be ended", async () => {
    const core = await load();
    const controller = new AbortController();
    const seen: Estimate[] = [];
    const walk = new Promise((resolve, reject) => {
      const soFar = (estimate: Estimate) => {
        seen.push(estimate);
        if (seen.length === 2) {
          core.layer(stack).then(() => controller.abort(), reject);
        }
      };
      core.walk(stack, [ways, others], endless, soFar, controller.signal).then(resolve, reject);
    });
    await expect(walk).rejects.toThrow(Cancelled);
    const [first, second] = seen.map(({ walks }) => walks) as [number, number];
    expect(second).toBeGreaterThan(first);
  });

  test("gives way to the next", async () => {
    const [first, second] = [walkOf(endless), walkOf({ seed: 2, walks: 4 })];
    expect((await first).walks).toBeLessThan(endless.walks);
    expect((await second).walks).toBe(4);
  });
});
