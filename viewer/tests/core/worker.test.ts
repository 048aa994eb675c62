/** The core behind messages, with both sides in this process. */

import { beforeEach, describe, expect, test } from "vitest";
import type { Stack } from "../../src/core/api";
import { type Port, RemoteCore, Superseded } from "../../src/core/client";
import { loadCore } from "../../src/core/core";
import type { Response } from "../../src/core/protocol";
import { FileError } from "../../src/core/safetensors";
import { Server } from "../../src/core/server";
import type { Estimate } from "../../src/core/walk/reference";
import { bytesOf, readVectors, SHIPPED } from "./vectors";

const vectors = readVectors("default");
const stacks = vectors?.stacks ?? [];
const stack = stacks[8] as Stack;
const wi = vectors?.of("wi") ?? new Float32Array();
const wo = vectors?.of("wo") ?? new Float32Array();
const weights = () => bytesOf(SHIPPED);

/** A server and a port to it, between which messages are copied and arrive later. */
function connected(): Port {
  let listener: (event: { data: Response }) => void = () => {};
  const server = new Server({
    post: (response, transfer) => {
      const data = structuredClone(response, { transfer });
      setTimeout(() => listener({ data }));
    },
    defer: (task) => setTimeout(task),
  });
  return {
    postMessage: (message, transfer) => {
      const data = structuredClone(message, { transfer });
      setTimeout(() => server.receive(data));
    },
    addEventListener: (_, added) => {
      listener = added;
    },
  };
}

let remote: RemoteCore;

beforeEach(() => {
  remote = new RemoteCore(connected());
});

describe("calls", { timeout: 30_000 }, () => {
  test("give what the core gives", async () => {
    const core = loadCore(weights());
    await remote.load(weights());
    expect(remote.latentSize).toBe(core.latentSize);
    const material = await remote.layer(stack);
    expect(material).toEqual(core.layer(stack));
    expect(await remote.f(material, wi, wo)).toEqual(core.f(material, wi, wo));
    const cosines = Float32Array.of(0.2, 0.9);
    expect(await remote.albedo(material, cosines)).toEqual(core.albedo(material, cosines));
    const options = { cosines: 2, samples: 4, shift: [0, 0.5, 0] } as const;
    expect(await remote.table(material, options)).toEqual(core.table(material, options));
  });

  test("fail with a sentence, and the next one is answered", async () => {
    await expect(remote.layer(stack)).rejects.toThrow("the networks are not loaded yet");
    await expect(remote.load(new ArrayBuffer(3))).rejects.toThrow(FileError);
    await remote.load(weights());
    expect((await remote.layer(stack)).latents).toHaveLength(3 * remote.latentSize);
  });
});

describe("a walk", { timeout: 30_000 }, () => {
  const pairs = [wi.slice(0, 30), wo.slice(0, 30)] as const;
  const endless = { seed: 2, walks: 1e9 };

  test("needs no networks, and ends with the walks asked for", async () => {
    const estimate = await remote.walk(stack, pairs, { seed: 1, walks: 20 }, () => {});
    expect(estimate.walks).toBe(20);
    expect(estimate.f).toHaveLength(30);
  });

  test("tells what it knows, leaves time for calls, and can be ended", async () => {
    await remote.load(weights());
    const controller = new AbortController();
    const seen: Estimate[] = [];
    const walk = new Promise((resolve, reject) => {
      const soFar = (estimate: Estimate) => {
        seen.push(estimate);
        if (seen.length === 2) {
          remote.layer(stack).then(() => controller.abort(), reject);
        }
      };
      remote.walk(stack, pairs, endless, soFar, controller.signal).then(resolve, reject);
    });
    await expect(walk).rejects.toThrow(Superseded);
    const [first, second] = seen.map(({ walks }) => walks) as [number, number];
    expect(second).toBeGreaterThan(first);
  });

  test("gives way to the next", async () => {
    const first = remote.walk(stack, pairs, endless, () => {});
    const second = remote.walk(stack, pairs, { seed: 2, walks: 4 }, () => {});
    await expect(first).rejects.toThrow(Superseded);
    expect((await second).walks).toBe(4);
  });
});
