import { expect, test } from "vitest";
import { History } from "../../src/state/history";

test("steps are taken back and taken again", () => {
  const history = new History<number>();
  history.record(1, "", 0);
  history.record(2, "", 1);
  expect(history.undo(3)).toBe(2);
  expect(history.undo(2)).toBe(1);
  expect(history.undo(1)).toBeNull();
  expect(history.redo(1)).toBe(2);
  expect(history.redo(2)).toBe(3);
  expect(history.canRedo).toBe(false);
});

test("changes of one kind that follow fast are one step", () => {
  const history = new History<number>();
  for (let value = 0; value < 10; value++) history.record(value, "slider", 100 * value);
  expect(history.undo(10)).toBe(0);
});

test("a pause or another kind begins a new step", () => {
  const history = new History<number>();
  history.record(1, "slider", 0);
  history.record(2, "slider", 5000);
  history.record(3, "other", 5001);
  expect([history.undo(4), history.undo(3), history.undo(2)]).toEqual([3, 2, 1]);
});

test("a new change forgets what was taken back", () => {
  const history = new History<number>();
  history.record(1, "", 0);
  history.undo(2);
  history.record(1, "", 1);
  expect(history.canRedo).toBe(false);
});
