/** Materials to begin with. All are described by physical parameters. */

import type { Rgb } from "./channels";
import { LIBRARY } from "./library";
import type { MaterialCards } from "./material";

/** Complex indices of refraction of metals, as Mitsuba has them in its RGB variants. */
export const METALS: Readonly<Record<string, { eta: Rgb; k: Rgb }>> = {
  Gold: { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] },
  Silver: { eta: [0.155, 0.117, 0.138], k: [4.828, 3.122, 2.147] },
  Copper: { eta: [0.201, 0.924, 1.102], k: [3.913, 2.453, 2.142] },
  Aluminium: { eta: [1.658, 0.88, 0.521], k: [9.224, 6.27, 4.837] },
  Chromium: { eta: [4.37, 2.917, 1.655], k: [5.207, 4.231, 3.755] },
  Tungsten: { eta: [4.371, 3.3, 2.998], k: [3.501, 2.605, 2.273] },
};

/** The library of materials. */
export const PRESETS: readonly MaterialCards[] = LIBRARY.map(({ coats, ...material }) => ({
  ...material,
  coats: coats.map((coat, place) => ({ ...coat, id: place + 1, on: true })),
  solo: null,
}));

/** A material's name, and whether it is of the library but was changed. */
export function titleOf(material: MaterialCards): string {
  const original = PRESETS.find(({ name }) => name === material.name);
  const content = ({ solo, ...rest }: MaterialCards) =>
    JSON.stringify(
      Object.entries(rest)
        .filter(([, value]) => value !== false)
        .sort(),
    );
  const isModified = original !== undefined && content(original) !== content(material);
  return isModified ? `${material.name} (modified)` : material.name;
}

/** The material of the library of a name. */
export function preset(name: string): MaterialCards {
  return PRESETS.find((material) => material.name === name)!;
}
