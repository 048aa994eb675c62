/** Materials to begin with. All are described by physical parameters. */

import { LIBRARY } from "../printed/library";
import type { Rgb } from "./channels";
import { CLEAR_COAT, type MaterialCards } from "./material";

/** Complex indices of refraction of metals, as Mitsuba has them in its RGB variants. */
export const METALS: Readonly<Record<string, { eta: Rgb; k: Rgb }>> = {
  Gold: { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] },
  Silver: { eta: [0.155, 0.117, 0.138], k: [4.828, 3.122, 2.147] },
  Copper: { eta: [0.201, 0.924, 1.102], k: [3.913, 2.453, 2.142] },
  Aluminium: { eta: [1.658, 0.88, 0.521], k: [9.224, 6.27, 4.837] },
  Chromium: { eta: [4.37, 2.917, 1.655], k: [5.207, 4.231, 3.755] },
  Tungsten: { eta: [4.371, 3.3, 2.998], k: [3.501, 2.605, 2.273] },
};

const metal = (name: string, { eta, k }: { eta: Rgb; k: Rgb }) => ({
  name,
  bottom: { kind: "conductor", alpha: 0.05, eta, k } as const,
  coats: [],
});

/** Glossy plastic of a reflectance. */
const plastic = (name: string, reflectance: number) => ({
  name,
  bottom: { kind: "diffuse", reflectance } as const,
  coats: [{ ...CLEAR_COAT, alpha: 0.05 }],
});

const PLAIN = [
  metal("Gold", METALS.Gold!),
  metal("Silver", METALS.Silver!),
  metal("Chrome", METALS.Chromium!),
  plastic("Black", 0.01),
  plastic("White", 0.8),
];

/** The library of materials. */
export const PRESETS: readonly MaterialCards[] = [...PLAIN, ...LIBRARY].map(
  ({ coats, ...material }) => ({
    ...material,
    coats: coats.map((coat, place) => ({ ...coat, id: place + 1, on: true })),
    solo: null,
  }),
);

/** Headings of the library, and what the names of their materials have in common. */
const GROUPS = {
  Lacquer: /urushi|nail/,
  Wood: / on (maple|spruce|walnut|oak|mahogany)/,
  "Car paint": /car paint/,
  "Enamel and glaze": /enamel|glaze|celadon|tenmoku/i,
  Metal: /brass|gilding|aluminium|silver|chromium|copper/i,
};

/** The heading of a material of the library, or "". */
export function groupOf({ name }: MaterialCards): string {
  if (PLAIN.some((plain) => plain.name === name)) return "Plain";
  return Object.entries(GROUPS).find(([, names]) => names.test(name))?.[0] ?? "";
}

/** A material's name, and whether it is of the library but was changed. */
export function titleOf(material: MaterialCards): string {
  const original = PRESETS.find(({ name }) => name === material.name);
  const isModified = original !== undefined && contentOf(original) !== contentOf(material);
  return isModified ? `${material.name} (modified)` : material.name;
}

/** What a material is, as a text, whatever the order of its parameters. */
function contentOf({ solo, ...content }: MaterialCards): string {
  return JSON.stringify(content, (_key, value) =>
    typeof value !== "object" || Array.isArray(value)
      ? value
      : Object.fromEntries(
          Object.entries(value)
            .filter(([, own]) => own !== false)
            .sort(),
        ),
  );
}

/** The material of the library of a name. */
export function preset(name: string): MaterialCards {
  return PRESETS.find((material) => material.name === name)!;
}
