/** The state of the page as a signal, its changes, and what the page says. */

import { computed, signal } from "@preact/signals";
import type { MaterialCards } from "../material/material";
import { Cancelled, Refusal, Unreachable } from "../refusal";
import { INITIAL, type State } from "./state";

export const state = signal<State>(INITIAL);
export const material = computed(() => state.value.materials[state.value.active]);

/** What went wrong, in a sentence, and what another try does if it may help. */
export interface Notice {
  text: string;
  retry?: (() => void) | undefined;
}

export const notice = signal<Notice | null>(null);
/** What the page does beside the picture: how much is done, from 0 to 1, and what ends it. */
export interface Task {
  text: string;
  share?: number | undefined;
  cancel?: () => void;
}

export const task = signal<Task | null>(null);

/**
 * Run a long task with a progress bar and a button to cancel it.
 *
 * @param run gets a signal to stop, and a function by which it reports its progress from 0 to 1.
 * @throws Refusal if there is another task.
 */
export async function asTask<T>(
  text: string,
  run: (end: AbortSignal, told: (share: number) => void) => Promise<T>,
): Promise<T> {
  if (task.value !== null)
    throw new Refusal("Something else is being done; wait until it has ended, or cancel it.");
  const abort = new AbortController();
  const tell = (share?: number) => {
    task.value = { text, share, cancel: () => abort.abort() };
  };
  tell();
  announce(text);
  try {
    return await run(abort.signal, (share) => {
      if (!abort.signal.aborted) tell(share);
    });
  } finally {
    task.value = null;
  }
}

/** What a screen reader announces. */
export const announcement = signal("");
let silence = 0;

/** Let a screen reader say a sentence, which does not stay: what is no news is not read. */
export function announce(text: string): void {
  announcement.value = text;
  clearTimeout(silence);
  silence = setTimeout(() => {
    announcement.value = "";
  }, 4000) as unknown as number;
}

/** Changes of the same kind within this time [ms] are one step. */
const PAUSE = 700;
const MOST_STEPS = 200;

/** States that were, and states that were taken back, the latest last. */
const past = signal<readonly State[]>([]);
const future = signal<readonly State[]>([]);
let latest = { kind: "", time: Number.NEGATIVE_INFINITY };
export const canUndo = computed(() => past.value.length > 0);
export const canRedo = computed(() => future.value.length > 0);

/** Change the state; changes of one `kind` that follow fast are one step, unless it is "". */
export function change(next: Partial<State>, kind = ""): void {
  const time = performance.now();
  const follows = kind !== "" && kind === latest.kind && time - latest.time < PAUSE;
  latest = { kind, time };
  if (!follows) past.value = [...past.value, state.value].slice(-MOST_STEPS);
  future.value = [];
  look(next);
}

/** Change the material on the cards. */
export function changeMaterial(next: MaterialCards, kind = ""): void {
  const { materials, active } = state.value;
  change({ materials: active === 0 ? [next, materials[1]] : [materials[0], next] }, kind);
}

/** Change what is no step of its own: where the camera stands, and the like. */
export function look(next: Partial<State>): void {
  state.value = { ...state.value, ...next };
}

export function undo(): void {
  step(past, future, "Undone");
}

export function redo(): void {
  step(future, past, "Redone");
}

function step(from: typeof past, to: typeof past, said: string): void {
  const value = from.value.at(-1);
  if (value === undefined) return;
  from.value = from.value.slice(0, -1);
  to.value = [...to.value, state.value];
  latest.kind = "";
  const { view, turntable, plots, edge, scale, incidence } = state.value;
  state.value = { ...value, view, turntable, plots, edge, scale, incidence };
  announce(said);
}

/** Tell what went wrong: `retry` tries again, and `context` is put before the sentence. */
export function complain(error: unknown, retry?: () => void, context = ""): void {
  if (error instanceof Cancelled) {
    announce(context + error.message);
  } else if (error instanceof Refusal) {
    const text = context + error.message;
    notice.value = { text, retry: error instanceof Unreachable ? retry : undefined };
  } else {
    console.error(error);
    notice.value = { text: `${context}Something went wrong (${error}); load the page anew.` };
  }
}

/** Put a sentence into the notice. */
export function tell(text: string): void {
  notice.value = { text };
}

/** Show a state that is read, as the first one or as a step; what is wrong with it is told. */
export function showRead(read: () => State, isStep: boolean): void {
  try {
    if (isStep) change(read());
    else state.value = read();
  } catch (error) {
    complain(error);
  }
}
