/** A button that opens a panel; Escape and a click elsewhere close it. */

import { useSignal } from "@preact/signals";
import type { ComponentChildren } from "preact";
import { useEffect, useRef } from "preact/hooks";

interface MenuProps {
  label: ComponentChildren;
  name: string;
  kind: string;
  children: (close: () => void) => ComponentChildren;
}

export function Menu({ label, name, kind, children }: MenuProps) {
  const open = useSignal(false);
  const root = useRef<HTMLDivElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const close = () => {
    open.value = false;
    button.current?.focus();
  };
  useEffect(() => {
    const outside = (event: Event) => {
      if (!root.current?.contains(event.target as Node)) open.value = false;
    };
    const end = new AbortController();
    document.addEventListener("pointerdown", outside, { signal: end.signal });
    document.addEventListener("focusin", outside, { signal: end.signal });
    return () => end.abort();
  }, [open]);
  return (
    // biome-ignore lint/a11y/noStaticElementInteractions: Escape closes what a button opened
    <div
      class={`menu ${kind}`}
      ref={root}
      onKeyDown={(event) => {
        if (event.key === "Escape" && open.value) close();
      }}
    >
      <button
        type="button"
        ref={button}
        class="opener"
        aria-label={name}
        aria-expanded={open.value}
        onClick={() => {
          open.value = !open.value;
        }}
      >
        {label}
      </button>
      {open.value && <div class="panel">{children(close)}</div>}
    </div>
  );
}
