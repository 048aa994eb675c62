/** A number that is typed. A value outside its range becomes the nearest one inside. */

import { useSignal } from "@preact/signals";

interface NumberFieldProps {
  name: string;
  value: number;
  low: number;
  high: number;
  onChange: (value: number) => void;
}

export function NumberField({ name, value, low, high, onChange }: NumberFieldProps) {
  const typed = useSignal<string | null>(null);
  const commit = () => {
    const text = typed.value;
    typed.value = null;
    if (text === null || text.trim() === "") return;
    const next = Number(text.replace(",", "."));
    if (Number.isFinite(next) && next !== value) onChange(Math.min(Math.max(next, low), high));
  };
  const step = (direction: number, large: boolean) => {
    const size = (value >= 1 ? 0.1 : value >= 0.1 ? 0.01 : 0.001) * (large ? 10 : 1);
    const next = Number((value + direction * size).toFixed(4));
    onChange(Math.min(Math.max(next, low), high));
  };
  return (
    <input
      type="text"
      inputMode="decimal"
      class="number"
      autocomplete="off"
      spellcheck={false}
      aria-label={name}
      value={typed.value ?? shown(value)}
      onInput={(event) => {
        const isTyped = typed.value !== null;
        typed.value = event.currentTarget.value;
        // An undo that goes back beyond what is being typed changes the number.
        if (!isTyped && event.inputType.startsWith("history")) commit();
      }}
      onFocus={(event) => event.currentTarget.select()}
      onBlur={commit}
      onKeyDown={(event) => {
        if (event.key === "Enter") commit();
        else if (event.key === "Escape") typed.value = null;
        else if (event.key === "ArrowUp" || event.key === "ArrowDown") {
          event.preventDefault();
          step(event.key === "ArrowUp" ? 1 : -1, event.shiftKey);
        }
      }}
    />
  );
}

function shown(value: number): string {
  return String(Number(value.toPrecision(4)));
}
