// Written by `python viewer/formulas.py` from the library of materials of Python. Do not edit it.

import type { BottomInAir, CoatInAir } from "./material";

/** A described material. */
interface Described {
  name: string;
  bottom: BottomInAir;
  coats: CoatInAir[];
  energyCompensation?: boolean;
}

export const LIBRARY: readonly Described[] = [
  {"name": "Black urushi", "bottom": {"kind": "diffuse", "reflectance": [0.012, 0.01, 0.01]}, "coats": [{"alpha": 0.02, "ior": 1.53, "g": 0.0, "color": [0.85, 0.65, 0.45], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Vermilion urushi", "bottom": {"kind": "diffuse", "reflectance": [0.012, 0.01, 0.01]}, "coats": [{"alpha": 0.02, "ior": 1.53, "g": 0.0, "color": [0.85, 0.65, 0.45], "body": 0.0, "bodyColor": 0.8}, {"alpha": 0.05, "ior": 1.53, "g": 0.0, "color": 1.0, "body": 1.0, "bodyColor": [0.62, 0.055, 0.02]}]},
  {"name": "Shellac on maple", "bottom": {"kind": "diffuse", "reflectance": [0.62, 0.44, 0.27]}, "coats": [{"alpha": 0.05, "ior": 1.516, "g": 0.0, "color": [0.95, 0.8, 0.52], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Spirit varnish on spruce", "bottom": {"kind": "diffuse", "reflectance": [0.58, 0.4, 0.22]}, "coats": [{"alpha": 0.04, "ior": 1.52, "g": 0.0, "color": [0.86, 0.42, 0.12], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Oil on walnut", "bottom": {"kind": "diffuse", "reflectance": [0.2, 0.105, 0.052]}, "coats": [{"alpha": 0.3, "ior": 1.48, "g": 0.0, "color": [0.97, 0.9, 0.74], "body": 0.0, "bodyColor": 0.8}], "energyCompensation": true},
  {"name": "Polyurethane on oak", "bottom": {"kind": "diffuse", "reflectance": [0.4, 0.27, 0.15]}, "coats": [{"alpha": 0.12, "ior": 1.5, "g": 0.0, "color": [0.97, 0.92, 0.8], "body": 0.0, "bodyColor": 0.8}], "energyCompensation": true},
  {"name": "French polish on mahogany", "bottom": {"kind": "diffuse", "reflectance": [0.26, 0.085, 0.042]}, "coats": [{"alpha": 0.015, "ior": 1.516, "g": 0.0, "color": 1.0, "body": 0.0, "bodyColor": 0.8}, {"alpha": 0.05, "ior": 1.516, "g": 0.0, "color": [0.9, 0.66, 0.4], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Solid white car paint", "bottom": {"kind": "diffuse", "reflectance": 0.3}, "coats": [{"alpha": 0.015, "ior": 1.5, "g": 0.0, "color": 1.0, "body": 0.0, "bodyColor": 0.8}, {"alpha": 0.1, "ior": 1.5, "g": 0.0, "color": 1.0, "body": 1.0, "bodyColor": 0.86}]},
  {"name": "Metallic red car paint", "bottom": {"kind": "conductor", "alpha": 0.33, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.015, "ior": 1.5, "g": 0.0, "color": 1.0, "body": 0.0, "bodyColor": 0.8}, {"alpha": 0.1, "ior": 1.5, "g": 0.0, "color": [0.7, 0.05, 0.03], "body": 0.04, "bodyColor": [0.6, 0.04, 0.03]}]},
  {"name": "Candy blue car paint", "bottom": {"kind": "conductor", "alpha": 0.22, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.015, "ior": 1.5, "g": 0.0, "color": 1.0, "body": 0.0, "bodyColor": 0.8}, {"alpha": 0.1, "ior": 1.5, "g": 0.0, "color": [0.04, 0.16, 0.72], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "White enamel", "bottom": {"kind": "conductor", "alpha": 0.3, "r0": [0.53, 0.51, 0.5]}, "coats": [{"alpha": 0.025, "ior": 1.55, "g": 0.0, "color": 1.0, "body": 1.0, "bodyColor": [0.86, 0.85, 0.82], "thickness": 2}]},
  {"name": "Blue enamel on copper", "bottom": {"kind": "conductor", "alpha": 0.15, "eta": [0.201, 0.924, 1.102], "k": [3.913, 2.453, 2.142]}, "coats": [{"alpha": 0.025, "ior": 1.55, "g": 0.0, "color": [0.05, 0.18, 0.62], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Green enamel on silver", "bottom": {"kind": "conductor", "alpha": 0.12, "eta": [0.155, 0.117, 0.138], "k": [4.828, 3.122, 2.147]}, "coats": [{"alpha": 0.025, "ior": 1.55, "g": 0.0, "color": [0.08, 0.52, 0.2], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Celadon", "bottom": {"kind": "diffuse", "reflectance": [0.66, 0.66, 0.62]}, "coats": [{"alpha": 0.04, "ior": 1.52, "g": 0.0, "color": [0.58, 0.83, 0.7], "body": 0.12, "bodyColor": [0.8, 0.88, 0.82]}]},
  {"name": "Tenmoku", "bottom": {"kind": "diffuse", "reflectance": [0.17, 0.075, 0.035]}, "coats": [{"alpha": 0.04, "ior": 1.56, "g": 0.0, "color": [0.2, 0.06, 0.02], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Honey glaze", "bottom": {"kind": "diffuse", "reflectance": [0.75, 0.7, 0.62]}, "coats": [{"alpha": 0.03, "ior": 1.52, "g": 0.0, "color": [0.8, 0.52, 0.22], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Lacquered brass", "bottom": {"kind": "conductor", "alpha": 0.12, "eta": [0.446, 0.538, 1.02], "k": [3.52, 2.72, 1.91]}, "coats": [{"alpha": 0.06, "ior": 1.49, "g": 0.0, "color": [0.98, 0.94, 0.84], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Gilding under shellac", "bottom": {"kind": "conductor", "alpha": 0.2, "eta": [0.143, 0.375, 1.442], "k": [3.983, 2.386, 1.603]}, "coats": [{"alpha": 0.05, "ior": 1.516, "g": 0.0, "color": [0.97, 0.86, 0.62], "body": 0.0, "bodyColor": 0.8}]},
  {"name": "Anodised aluminium", "bottom": {"kind": "conductor", "alpha": 0.25, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.2, "ior": 1.65, "g": 0.0, "color": [0.1, 0.3, 0.66], "body": 0.0, "bodyColor": 0.8}], "energyCompensation": true},
  {"name": "Tarnished silver", "bottom": {"kind": "conductor", "alpha": 0.15, "eta": [0.155, 0.117, 0.138], "k": [4.828, 3.122, 2.147]}, "coats": [{"alpha": 0.2, "ior": 2.2, "g": 0.0, "color": [0.6, 0.45, 0.24], "body": 0.05, "bodyColor": [0.1, 0.08, 0.06]}], "energyCompensation": true},
  {"name": "Red nail lacquer", "bottom": {"kind": "diffuse", "reflectance": [0.72, 0.5, 0.42]}, "coats": [{"alpha": 0.02, "ior": 1.48, "g": 0.0, "color": 1.0, "body": 0.9, "bodyColor": [0.55, 0.02, 0.04]}]},
  {"name": "Sheer pink nail lacquer", "bottom": {"kind": "diffuse", "reflectance": [0.72, 0.5, 0.42]}, "coats": [{"alpha": 0.02, "ior": 1.48, "g": 0.0, "color": [0.98, 0.72, 0.74], "body": 0.1, "bodyColor": [0.9, 0.6, 0.62]}]},
  {"name": "Brushed chromium", "bottom": {"kind": "conductor", "alpha": 0.06, "alphaV": 0.3, "eta": [4.37, 2.917, 1.655], "k": [5.207, 4.231, 3.755]}, "coats": []},
  {"name": "Brushed copper under lacquer", "bottom": {"kind": "conductor", "alpha": 0.06, "alphaV": 0.3, "eta": [0.201, 0.924, 1.102], "k": [3.913, 2.453, 2.142]}, "coats": [{"alpha": 0.03, "ior": 1.49, "g": 0.0, "color": 1.0, "body": 0.0, "bodyColor": 0.8}]},
];
