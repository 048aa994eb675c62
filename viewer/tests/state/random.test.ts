/** Random states: what is saved is read again, and every change is taken back. */

import { expect, test, vi } from "vitest";
import { fromAddress, toAddress, toJson } from "../../src/state/address";
import { readState } from "../../src/state/read";
import { canRedo, change, look, redo, state, undo } from "../../src/state/store";
import { Draws } from "../material/random";

test("addresses and saved states hold random states", () => {
  const draws = new Draws(1);
  for (let round = 0; round < 100; round++) {
    const drawn = draws.state();
    expect(fromAddress(toAddress(drawn))).toEqual(drawn);
    expect(readState(JSON.parse(toJson(drawn, 2)))).toEqual(drawn);
  }
});

test("random changes are undone and redone, and the camera stays", () => {
  const draws = new Draws(2);
  const states = [state.value];
  for (let round = 0; round < 60; round++) {
    if (draws.chance(0.3)) look({ view: draws.state().view });
    const { view } = state.value;
    const next = draws.pick([
      () => ({ ...draws.state(), view }),
      () => ({ ...state.value, exposure: draws.number(-6, 6) }),
      () => ({ ...state.value, materials: draws.state().materials }),
    ])();
    change(next);
    states.push(next);
  }
  const { view, turntable, plots, edge, scale, incidence } = state.value;
  const seen = (at: number) => ({ ...states[at], view, turntable, plots, edge, scale, incidence });
  for (let at = states.length - 2; at >= 0; at--) {
    undo();
    expect(state.value).toEqual(seen(at));
  }
  for (let at = 1; at < states.length; at++) {
    redo();
    expect(state.value).toEqual(seen(at));
  }
});

test("fast changes of one kind are one step; a pause or another kind begins a step", () => {
  vi.useFakeTimers();
  const before = state.value;
  const turn = (rotation: number, kind = "turn") => change({ ...state.value, rotation }, kind);
  for (const rotation of [1, 2, 3]) turn(rotation);
  vi.advanceTimersByTime(5000);
  turn(4);
  turn(5, "other");
  for (const rotation of [4, 3, before.rotation]) {
    undo();
    expect(state.value.rotation).toBe(rotation);
  }
  turn(6);
  expect(canRedo.value).toBe(false); // a new change forgets what was taken back
  vi.useRealTimers();
});
