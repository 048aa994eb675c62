/** The state of the page as a signal, its changes, and what the page says. */

import { computed, signal } from "@preact/signals";
import type { MaterialCards } from "../material/material";
import { Refusal } from "../refusal";
import { History } from "./history";
import { activeMaterial, INITIAL, type State, withMaterial } from "./state";

export const state = signal<State>(INITIAL);
export const material = computed(() => activeMaterial(state.value));

/** A sentence for the user, or "". */
export const notice = signal("");
/** What a screen reader announces. */
export const announcement = signal("");

const history = new History<State>();
const steps = signal(0);
export const canUndo = computed(() => steps.value >= 0 && history.canUndo);
export const canRedo = computed(() => steps.value >= 0 && history.canRedo);

/** Change the state; `kind` joins changes that follow each other, see `History.record`. */
export function change(next: State, kind = ""): void {
  if (next === state.value) return;
  history.record(state.value, kind, performance.now());
  state.value = next;
  steps.value++;
}

/** Change the material on the cards. */
export function changeMaterial(next: MaterialCards, kind = ""): void {
  change(withMaterial(state.value, next), kind);
}

/** Change what is no step of its own: where the camera stands, and the like. */
export function look(next: Partial<State>): void {
  state.value = { ...state.value, ...next };
}

export function undo(): void {
  restore(history.undo(state.value), "Undone");
}

export function redo(): void {
  restore(history.redo(state.value), "Redone");
}

function restore(value: State | null, said: string): void {
  if (value === null) return;
  const { view, edge, scale, incidence } = state.value;
  state.value = { ...value, view, edge, scale, incidence };
  announcement.value = said;
  steps.value++;
}

/** Begin with a state that is read; what is wrong with it is told in one sentence. */
export function begunWith(read: () => State): void {
  try {
    state.value = read();
  } catch (error) {
    if (!(error instanceof Refusal || error instanceof SyntaxError)) throw error;
    notice.value = error.message;
  }
}
