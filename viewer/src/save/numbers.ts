/** Values as text. */

import type { Channels } from "../core/api";

/** "0.1" or "0.1, 0.2, 0.3". */
export function listed(value: Channels): string {
  return typeof value === "number" ? String(value) : value.join(", ");
}

/** "0.1" or "(0.1, 0.2, 0.3)". */
export function python(value: Channels): string {
  return typeof value === "number" ? String(value) : `(${value.join(", ")})`;
}
