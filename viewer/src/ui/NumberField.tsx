/** A number that is typed. A value outside its range becomes the nearest one inside. */

interface NumberFieldProps {
  name: string;
  value: number;
  low: number;
  high: number;
  onChange: (value: number) => void;
}

export function NumberField({ name, value, low, high, onChange }: NumberFieldProps) {
  /** Take over a number; what is none leaves the value. */
  const set = (field: HTMLInputElement, typed: number) => {
    const next = Number.isFinite(typed) ? Math.min(Math.max(typed, low), high) : value;
    field.value = shown(next);
    if (next !== value) onChange(next);
  };
  const commit = (field: HTMLInputElement) => {
    const text = field.value.trim().replace(",", ".");
    if (text !== shown(value)) set(field, text === "" ? Number.NaN : Number(text));
  };
  return (
    <input
      type="text"
      inputMode="decimal"
      class="number"
      autocomplete="off"
      spellcheck={false}
      aria-label={name}
      value={shown(value)}
      onInput={({ currentTarget, inputType }) => {
        // An undo goes back beyond what is being typed.
        if (inputType.startsWith("history")) commit(currentTarget);
      }}
      onFocus={({ currentTarget }) => currentTarget.select()}
      onBlur={({ currentTarget }) => commit(currentTarget)}
      onKeyDown={(event) => {
        const { currentTarget: field, key } = event;
        if (key === "Enter") commit(field);
        if (key === "Escape") field.value = shown(value);
        const way = { ArrowUp: 1, ArrowDown: -1 }[key];
        if (way === undefined) return;
        event.preventDefault();
        const amount = Math.abs(value);
        const size = (amount >= 1 ? 0.1 : amount >= 0.1 ? 0.01 : 0.001) * (event.shiftKey ? 10 : 1);
        set(field, Number((value + way * size).toFixed(4)));
      }}
    />
  );
}

function shown(value: number): string {
  return String(Number(value.toPrecision(4)));
}
