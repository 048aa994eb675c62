/** A slider with its name and its value, for what belongs to the picture. */

import { Slider } from "./Slider";

interface DialProps {
  label: string;
  text: string;
  value: number;
  low: number;
  high: number;
  step: number;
  /** One sentence on what it does. */
  hint: string;
  /** Value after a double click. */
  fallback?: number;
  onInput: (value: number) => void;
}

export function Dial({ label, hint, fallback = 0, ...dial }: DialProps) {
  return (
    <label title={hint}>
      <span>{label}</span>
      <Slider {...dial} onReset={() => dial.onInput(fallback)} />
      <output>{dial.text}</output>
    </label>
  );
}
