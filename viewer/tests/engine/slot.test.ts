import { expect, test, vi } from "vitest";
import type { Stack } from "../../src/core/api";
import { type Shown, Slot } from "../../src/engine/engine";
import { Cores, once, type PageCore } from "../../src/engine/remote";
import { Refusal } from "../../src/refusal";

const table = { logs: new Float32Array(), besideLobe: true };

/** The width of a coat that cannot be layered. */
const BROKEN = 0.875;

/** A core that answers late, with the stack's first width in every number. */
function lateCore(): { core: PageCore; layered: number[]; shifts: number[] } {
  const layered: number[] = [];
  const shifts: number[] = [];
  const late = () => new Promise((resolve) => setTimeout(resolve, 1));
  const core: PageCore = {
    latentSize: 1,
    widths: 1,
    fingerprint: "",
    basisTexels: async () => new Float32Array(),
    layer: async (stack) => {
      const width = stack.coats[0].alpha as number;
      layered.push(width);
      await late();
      if (width === BROKEN) throw new Refusal("It cannot be layered.");
      return { latents: new Float32Array([width]), table };
    },
    f: async (material, wi) => new Float32Array(wi.length).fill(material.latents[0]),
    albedo: async (_material, cosines) => new Float32Array(3 * cosines.length),
    table: async (material, { shift }) => {
      shifts.push(shift[0]);
      await late();
      return new Float32Array([material.latents[0]]);
    },
  };
  return { core, layered, shifts };
}

function shown(alpha: number): Shown {
  const coat = { alpha, eta: 1.5, albedo: 0, sigmaT: 0, g: 0 };
  const stack: Stack = { bottom: { kind: "diffuse", reflectance: 0.5 }, coats: [coat] };
  return { stack, rotation: 0, texture: null };
}

/** A slot, and what it has complained about. */
function slotOf(core: PageCore, complaints: unknown[] = []): Slot {
  return new Slot(new Cores(core), {
    changed: () => {},
    failed: (error) => complaints.push(error),
    incidence: () => 45,
  });
}

/** Wait until a slot shows a width. */
const settled = (slot: Slot, width: number) =>
  vi.waitFor(() => expect(slot.plane.value?.[0]).toBe(width), { timeout: 30_000 });

test("of many changes the latest is shown, and those between are left out", async () => {
  const { core, layered } = lateCore();
  const slot = slotOf(core);
  for (let step = 1; step <= 20; step++) slot.show(shown(step / 32));
  await settled(slot, 20 / 32);
  expect(layered).toEqual([1 / 32, 20 / 32]);
  expect([...slot.tables[0]]).toEqual([20 / 32]);
});

test("an equal stack is not computed again", async () => {
  const { core, layered } = lateCore();
  const slot = slotOf(core);
  slot.show(shown(0.5));
  await settled(slot, 0.5);
  slot.show(shown(0.5));
  slot.show(shown(0.25));
  await settled(slot, 0.25);
  expect(layered).toEqual([0.5, 0.25]);
});

test("tables at rest are shifted, and belong to the present material", async () => {
  const { core, shifts } = lateCore();
  const slot = slotOf(core);
  slot.show(shown(0.5));
  await settled(slot, 0.5);
  expect(slot.tables).toHaveLength(1);
  expect(await slot.another()).toBe(true);
  expect(await slot.another()).toBe(true);
  const late = slot.another();
  slot.show(shown(0.25));
  expect(await late).toBe(false);
  await settled(slot, 0.25);
  expect(slot.tables).toHaveLength(1);
  expect([...slot.tables[0]]).toEqual([0.25]);
  expect(new Set(shifts.slice(0, 4)).size).toBe(4); // of the first, and of three at rest
});

test("what fails is told, unless a later change has taken its place, which is shown", async () => {
  const complaints: unknown[] = [];
  const slot = slotOf(lateCore().core, complaints);
  slot.show(shown(BROKEN));
  slot.show(shown(0.5));
  await settled(slot, 0.5);
  expect(complaints).toEqual([]);
  slot.show(shown(BROKEN));
  await vi.waitFor(() => expect(complaints).toHaveLength(1));
  slot.show(shown(0.25));
  await settled(slot, 0.25);
});

test("what is made once is made again after a failure", async () => {
  let tries = 0;
  const made = once(async () => {
    if (++tries === 1) throw new Refusal("The file could not be fetched.");
    return tries;
  });
  await expect(made()).rejects.toThrow(Refusal);
  expect(await Promise.all([made(), made()])).toEqual([2, 2]);
  expect(await made()).toBe(2);
});
