/** A slider with its name and its value, for what belongs to the picture. */

import { Slider } from "./Slider";

interface DialProps {
  label: string;
  text: string;
  value: number;
  low: number;
  high: number;
  step: number;
  /** Value after a double click. */
  fallback?: number;
  onInput: (value: number) => void;
}

export function Dial({ label, fallback = 0, ...dial }: DialProps) {
  return (
    <label>
      <span>{label}</span>
      <Slider {...dial} onReset={() => dial.onInput(fallback)} />
      <output>{dial.text}</output>
    </label>
  );
}
