/** Materials to begin with. All are described by physical parameters. */

import type { Bottom, Coat } from "../core/api";
import type { MaterialCards } from "./material";
import { METALS } from "./metals";

function material(name: string, bottom: Bottom, ...coats: Partial<Coat>[]): MaterialCards {
  return {
    name,
    bottom,
    coats: coats.map((coat, place) => ({
      ...{ alpha: 0.1, eta: 1.5, albedo: 0, sigmaT: 0, g: 0 },
      ...coat,
      id: place + 1,
      on: true,
    })),
    solo: null,
  };
}

function metal(name: keyof typeof METALS & string, alpha: number): Bottom {
  const { eta, k } = METALS[name]!;
  return { kind: "conductor", alpha, eta, k };
}

export const PRESETS: readonly MaterialCards[] = [
  material(
    "Vermilion urushi",
    { kind: "diffuse", reflectance: [0.1, 0.05, 0.035] },
    { alpha: 0.03, eta: 1.53, sigmaT: [0.05, 0.14, 0.4] },
    { alpha: 0.08, eta: 1.02, sigmaT: [3, 6, 6.5], albedo: [0.88, 0.16, 0.06], g: 0.2 },
  ),
  material(
    "Black urushi",
    { kind: "diffuse", reflectance: [0.02, 0.015, 0.012] },
    { alpha: 0.02, eta: 1.53, sigmaT: [0.3, 0.5, 0.9] },
    { alpha: 0.06, eta: 1.02, sigmaT: [4, 5, 6], albedo: [0.1, 0.06, 0.045] },
  ),
  material("Gold maki-e", metal("Gold", 0.28), {
    alpha: 0.03,
    eta: 1.53,
    sigmaT: [0.02, 0.09, 0.3],
  }),
  material(
    "Car paint",
    metal("Aluminium", 0.33),
    { alpha: 0.015, eta: 1.45 },
    { alpha: 0.1, eta: 1.07, sigmaT: [0.15, 1.5, 1.8], albedo: [0.6, 0.04, 0.03], g: 0.4 },
  ),
  material(
    "Varnished walnut",
    { kind: "diffuse", reflectance: [0.3, 0.15, 0.068] },
    { alpha: 0.06, eta: 1.5, sigmaT: [0.03, 0.1, 0.3] },
  ),
  material("Enamel on copper", metal("Copper", 0.22), {
    alpha: 0.04,
    eta: 1.52,
    sigmaT: [1.4, 0.5, 0.14],
    albedo: [0.05, 0.18, 0.5],
    g: 0.3,
  }),
  material(
    "Celadon glaze",
    { kind: "diffuse", reflectance: [0.52, 0.49, 0.42] },
    { alpha: 0.035, eta: 1.52, sigmaT: [1.5, 0.75, 1], albedo: [0.62, 0.93, 0.84], g: 0.3 },
  ),
  material("Frosted metal", metal("Aluminium", 0.04), {
    alpha: 0.42,
    eta: 1.5,
    sigmaT: [0.02, 0.09, 0.2],
  }),
  material(
    "Pearl",
    { kind: "diffuse", reflectance: [0.8, 0.76, 0.73] },
    { alpha: 0.05, eta: 1.5 },
    { alpha: 0.28, eta: 1.25, sigmaT: [0.6, 0.75, 0.7], albedo: [0.99, 0.965, 0.97], g: 0.2 },
    { alpha: 0.35, eta: 1.1, sigmaT: [0.25, 0.2, 0.3], albedo: [0.97, 0.98, 0.95] },
  ),
  material("Tarnished silver", metal("Silver", 0.14), {
    alpha: 0.3,
    eta: 1.35,
    sigmaT: [0.25, 0.42, 0.62],
    albedo: [0.12, 0.1, 0.12],
  }),
];
