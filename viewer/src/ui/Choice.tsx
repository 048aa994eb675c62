/** A choice among few values: a menu, or buttons beside each other. */

import type { ComponentChildren } from "preact";
import { Button } from "./Button";

interface ChoiceProps<Value extends string | number> {
  /** For screen readers, unless a label names it. */
  name?: string;
  value: Value;
  /** Values and what is shown of them. */
  options: readonly (readonly [Value, ComponentChildren])[];
  onChange: (value: Value) => void;
}

export function Choice<Value extends string | number>(props: ChoiceProps<Value>) {
  const { name, value, options, onChange } = props;
  return (
    <select
      aria-label={name}
      value={value}
      onChange={({ currentTarget }) => onChange(options[currentTarget.selectedIndex][0])}
    >
      {options.map(([own, shown]) => (
        <option key={own} value={own}>
          {shown}
        </option>
      ))}
    </select>
  );
}

export function Segments<Value extends string | number>(props: ChoiceProps<Value>) {
  const { name, value, options, onChange } = props;
  return (
    <div class="segments" role="group" aria-label={name}>
      {options.map(([own, shown]) => (
        <Button key={own} aria-pressed={own === value} onClick={() => onChange(own)}>
          {shown}
        </Button>
      ))}
    </div>
  );
}
