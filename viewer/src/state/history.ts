/** Undo and redo: values that were, and values that were taken back. */

/** Changes of the same kind within this time [ms] are one step. */
const PAUSE = 700;

export class History<T> {
  private past: T[] = [];
  private future: T[] = [];
  private kind = "";
  private time = Number.NEGATIVE_INFINITY;

  /**
   * Record a change.
   *
   * @param before the value that is left.
   * @param kind changes of the same kind that follow fast are one step; "" always is a step.
   * @param now time [ms].
   */
  record(before: T, kind: string, now: number): void {
    const follows = kind !== "" && kind === this.kind && now - this.time < PAUSE;
    if (!follows) this.past.push(before);
    if (this.past.length > 200) this.past.shift();
    this.future = [];
    this.kind = kind;
    this.time = now;
  }

  /** The value before the last step, or null. */
  undo(present: T): T | null {
    return this.step(this.past, this.future, present);
  }

  /** The value after the step that was taken back, or null. */
  redo(present: T): T | null {
    return this.step(this.future, this.past, present);
  }

  get canUndo(): boolean {
    return this.past.length > 0;
  }

  get canRedo(): boolean {
    return this.future.length > 0;
  }

  private step(from: T[], to: T[], present: T): T | null {
    const value = from.pop();
    if (value === undefined) return null;
    to.push(present);
    this.kind = "";
    return value;
  }
}
