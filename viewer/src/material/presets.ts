/** Materials to begin with. All are described by physical parameters. */

import {
  type BottomInAir,
  CLEAR_COAT,
  type CoatInAir,
  type MaterialCards,
  type Rgb,
} from "./material";

/** Complex indices of refraction of metals, as Mitsuba has them in its RGB variants. */
export const METALS: Readonly<Record<string, { eta: Rgb; k: Rgb }>> = {
  Gold: { eta: [0.143, 0.375, 1.442], k: [3.983, 2.386, 1.603] },
  Silver: { eta: [0.155, 0.117, 0.138], k: [4.828, 3.122, 2.147] },
  Copper: { eta: [0.201, 0.924, 1.102], k: [3.913, 2.453, 2.142] },
  Aluminium: { eta: [1.658, 0.88, 0.521], k: [9.224, 6.27, 4.837] },
  Chromium: { eta: [4.37, 2.917, 1.655], k: [5.207, 4.231, 3.755] },
  Tungsten: { eta: [4.371, 3.3, 2.998], k: [3.501, 2.605, 2.273] },
};

function material(
  name: string,
  bottom: BottomInAir,
  ...coats: Partial<CoatInAir>[]
): MaterialCards {
  return {
    name,
    bottom,
    coats: coats.map((coat, place) => ({
      ...CLEAR_COAT,
      ...coat,
      id: place + 1,
      on: true,
    })),
    solo: null,
  };
}

function metal(name: keyof typeof METALS & string, alpha: number): BottomInAir {
  const { eta, k } = METALS[name]!;
  return { kind: "conductor", alpha, eta, k };
}

export const PRESETS: readonly MaterialCards[] = [
  material(
    "Vermilion urushi",
    { kind: "diffuse", reflectance: [0.1, 0.05, 0.035] },
    { alpha: 0.03, ior: 1.53, sigmaT: [0.03, 0.08, 0.22] },
    { alpha: 0.08, ior: 1.56, sigmaT: 8, albedo: [0.995, 0.66, 0.42], g: 0.2 },
  ),
  material(
    "Black urushi",
    { kind: "diffuse", reflectance: [0.02, 0.015, 0.012] },
    { alpha: 0.02, ior: 1.53, sigmaT: [0.3, 0.5, 0.9] },
    { alpha: 0.06, ior: 1.56, sigmaT: [4, 5, 6], albedo: [0.1, 0.06, 0.045] },
  ),
  material("Gold maki-e", metal("Gold", 0.28), {
    alpha: 0.03,
    ior: 1.53,
    sigmaT: [0.02, 0.07, 0.2],
  }),
  material(
    "Car paint",
    metal("Aluminium", 0.33),
    { alpha: 0.015, ior: 1.45 },
    { alpha: 0.1, ior: 1.55, sigmaT: [1.4, 0.55, 0.12], albedo: [0.05, 0.2, 0.7], g: 0.4 },
  ),
  material(
    "Varnished walnut",
    { kind: "diffuse", reflectance: [0.42, 0.22, 0.1] },
    { alpha: 0.06, ior: 1.5, sigmaT: [0.03, 0.1, 0.3] },
  ),
  material("Enamel on copper", metal("Copper", 0.2), {
    alpha: 0.03,
    ior: 1.52,
    sigmaT: [0.06, 0.85, 1.2],
    albedo: [0, 0.02, 0.03],
  }),
  material(
    "Celadon glaze",
    { kind: "diffuse", reflectance: [0.6, 0.57, 0.5] },
    { alpha: 0.035, ior: 1.52, sigmaT: [1.2, 0.7, 0.85], albedo: [0.88, 0.975, 0.945], g: 0.3 },
  ),
  material("Frosted metal", metal("Aluminium", 0.04), {
    alpha: 0.42,
    ior: 1.5,
    sigmaT: [0.02, 0.025, 0.035],
  }),
  material(
    "Pearl",
    { kind: "diffuse", reflectance: [0.88, 0.85, 0.82] },
    { alpha: 0.04, ior: 1.5 },
    { alpha: 0.3, ior: 1.68, sigmaT: [1.2, 1.35, 1.3], albedo: [0.998, 0.995, 0.997], g: 0.2 },
  ),
  material("Tarnished silver", metal("Silver", 0.14), {
    alpha: 0.3,
    ior: 1.35,
    sigmaT: [0.08, 0.13, 0.22],
    albedo: [0.12, 0.1, 0.12],
  }),
];
