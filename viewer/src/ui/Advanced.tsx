/** What is needed less often, folded. */

import { signal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { toggled } from "./Field";

/** Those that are unfolded. */
const unfolded = signal<ReadonlySet<number>>(new Set());

/** @param of number of the coat, or 0 for the bottom. */
export function Advanced({ of, children }: { of: number; children: ComponentChildren }) {
  return (
    <details
      open={unfolded.value.has(of)}
      onToggle={({ currentTarget: { open } }) => {
        if (open !== unfolded.value.has(of)) unfolded.value = toggled(unfolded.value, of);
      }}
    >
      <summary>Advanced</summary>
      {children}
    </details>
  );
}
