/** A slider. A touch moves it along only: a swipe up or down that starts on it scrolls the page. */

import { useRef } from "preact/hooks";

interface SliderProps {
  /** For screen readers, unless a label names it; the value in words. */
  name?: string;
  text: string;
  class?: string;
  /** The track's background, instead of how far it is filled. */
  track?: string | undefined;
  low: number;
  high: number;
  step: number;
  value: number;
  onInput: (value: number) => void;
  /** After a double click. */
  onReset: () => void;
}

/**
 * The value of a slider after a key: the arrows move it by a step, Home and End to the ends of its
 * range; undefined: the key is another one.
 */
export function valueByKey(
  event: KeyboardEvent,
  value: number,
  step: number,
  low: number,
  high: number,
): number | undefined {
  const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
  const end = { Home: low, End: high }[event.key];
  if (way === undefined && end === undefined) return undefined;
  event.preventDefault();
  return end ?? Math.min(Math.max(value + way! * step, low), high);
}

/** Pixels along the slider that tell a move from a swipe. */
const MOVE = 6;

export function Slider({ name, text, low, high, step, value, onInput, ...props }: SliderProps) {
  /** A touch that may yet become a swipe: where it began, and the value that it points at. */
  const touch = useRef<{ x: number; y: number; value: number } | null>(null);
  const settle = (element: HTMLInputElement, next: number) => {
    touch.current = null;
    element.value = String(next);
    onInput(next);
  };
  return (
    <input
      type="range"
      class={`${props.class ?? ""} ${props.track ? "graded" : ""}`}
      aria-label={name}
      aria-valuetext={text}
      min={low}
      max={high}
      step={step}
      value={value}
      style={{
        "--fill": `${((100 * (value - low)) / (high - low)).toFixed(2)}%`,
        "--graded": props.track,
      }}
      onPointerDown={({ pointerType, clientX: x, clientY: y }) => {
        touch.current = pointerType === "touch" ? { x, y, value } : null;
      }}
      onInput={({ currentTarget: element }) => {
        if (touch.current === null) return onInput(Number(element.value));
        touch.current.value = Number(element.value);
        element.value = String(value);
      }}
      onPointerMove={({ currentTarget: element, clientX, clientY }) => {
        if (touch.current === null) return;
        const along = Math.abs(clientX - touch.current.x);
        if (along >= MOVE && along > Math.abs(clientY - touch.current.y))
          settle(element, touch.current.value);
      }}
      onPointerUp={({ currentTarget: element }) => {
        if (touch.current !== null) settle(element, touch.current.value);
      }}
      onPointerCancel={() => {
        touch.current = null;
      }}
      onDblClick={props.onReset}
      onKeyDown={(event) => {
        if (event.key === "Delete" || event.key === "Backspace") props.onReset();
      }}
    />
  );
}
