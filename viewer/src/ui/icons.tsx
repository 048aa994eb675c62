/** Line icons on a grid of 16 by 16. */

const PATHS = {
  undo: "M6 3 3 6l3 3M3 6h6.5a3.5 3.5 0 0 1 0 7H6",
  redo: "m10 3 3 3-3 3m3-3H6.5a3.5 3.5 0 0 0 0 7H10",
  plus: "M8 3v10M3 8h10",
  cross: "m4 4 8 8m0-8-8 8",
  grip: "M6 4v.01M10 4v.01M6 8v.01M10 8v.01M6 12v.01M10 12v.01",
  eye: "M1.5 8S4 3.5 8 3.5 14.5 8 14.5 8 12 12.5 8 12.5 1.5 8 1.5 8ZM8 10a2 2 0 1 0 0-4 2 2 0 0 0 0 4Z",
  hidden:
    "m2 2 12 12M6.5 3.700A6 6 0 0 1 8 3.5c4 0 6.5 4.5 6.5 4.5a12 12 0 0 1-2 2.5M4 5a12 12 0 0 0-2.5 3S4 12.5 8 12.5a6 6 0 0 0 2.5-.55",
  down: "m4 6 4 4 4-4",
  save: "M8 2v8m-3-3 3 3 3-3M3 12.5h10",
  open: "M2.5 12.5v-9h4l1.5 2h5.5v7Z",
  sliders:
    "M2 5h6m3 0h3M2 11h3m3 0h6M9.500 6.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3ZM6.500 12.500a1.500 1.500 0 1 0 0-3 1.500 1.500 0 0 0 0 3Z",
  swap: "M3 6h9.5L10 3.5M13 10H3.5L6 12.5",
} as const;

export type IconName = keyof typeof PATHS;

export function Icon({ name }: { name: IconName }) {
  return (
    <svg class="icon" viewBox="0 0 16 16" aria-hidden="true" focusable="false">
      <path d={PATHS[name]} />
    </svg>
  );
}
