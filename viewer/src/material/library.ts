// Written by `python viewer/formulas.py` from the library of materials of Python. Do not edit it.

import type { BottomInAir, CoatInAir } from "./material";

export const LIBRARY: readonly { name: string; bottom: BottomInAir; coats: CoatInAir[] }[] = [
  {"name": "Black urushi", "bottom": {"kind": "diffuse", "reflectance": [0.012, 0.01, 0.01]}, "coats": [{"alpha": 0.02, "ior": 1.53, "albedo": 0.0, "sigmaT": [0.081, 0.215, 0.399], "g": 0.0}]},
  {"name": "Vermilion urushi", "bottom": {"kind": "diffuse", "reflectance": [0.012, 0.01, 0.01]}, "coats": [{"alpha": 0.02, "ior": 1.53, "albedo": 0.0, "sigmaT": [0.081, 0.215, 0.399], "g": 0.0}, {"alpha": 0.05, "ior": 1.53, "albedo": [0.957, 0.237, 0.095], "sigmaT": 132.0, "g": 0.0}]},
  {"name": "Shellac on maple", "bottom": {"kind": "diffuse", "reflectance": [0.62, 0.44, 0.27]}, "coats": [{"alpha": 0.05, "ior": 1.516, "albedo": 0.0, "sigmaT": [0.026, 0.112, 0.327], "g": 0.0}]},
  {"name": "Spirit varnish on spruce", "bottom": {"kind": "diffuse", "reflectance": [0.58, 0.4, 0.22]}, "coats": [{"alpha": 0.04, "ior": 1.52, "albedo": 0.0, "sigmaT": [0.075, 0.434, 1.06], "g": 0.0}]},
  {"name": "Oil on walnut", "bottom": {"kind": "diffuse", "reflectance": [0.2, 0.105, 0.052]}, "coats": [{"alpha": 0.3, "ior": 1.48, "albedo": 0.0, "sigmaT": [0.015, 0.053, 0.151], "g": 0.0}]},
  {"name": "Polyurethane on oak", "bottom": {"kind": "diffuse", "reflectance": [0.4, 0.27, 0.15]}, "coats": [{"alpha": 0.12, "ior": 1.5, "albedo": 0.0, "sigmaT": [0.015, 0.042, 0.112], "g": 0.0}]},
  {"name": "French polish on mahogany", "bottom": {"kind": "diffuse", "reflectance": [0.26, 0.085, 0.042]}, "coats": [{"alpha": 0.015, "ior": 1.516, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}, {"alpha": 0.05, "ior": 1.516, "albedo": 0.0, "sigmaT": [0.053, 0.208, 0.458], "g": 0.0}]},
  {"name": "Solid white car paint", "bottom": {"kind": "diffuse", "reflectance": 0.3}, "coats": [{"alpha": 0.015, "ior": 1.5, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}, {"alpha": 0.1, "ior": 1.5, "albedo": 0.996, "sigmaT": 132.0, "g": 0.0}]},
  {"name": "Metallic red car paint", "bottom": {"kind": "conductor", "alpha": 0.33, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.015, "ior": 1.5, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}, {"alpha": 0.1, "ior": 1.5, "albedo": [0.226, 0.006, 0.004], "sigmaT": [0.234, 1.553, 1.809], "g": 0.0}]},
  {"name": "Candy blue car paint", "bottom": {"kind": "conductor", "alpha": 0.22, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.015, "ior": 1.5, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}, {"alpha": 0.1, "ior": 1.5, "albedo": 0.0, "sigmaT": [1.609, 0.916, 0.164], "g": 0.0}]},
  {"name": "White enamel", "bottom": {"kind": "conductor", "alpha": 0.3, "r0": [0.53, 0.51, 0.5]}, "coats": [{"alpha": 0.025, "ior": 1.55, "albedo": [0.996, 0.995, 0.993], "sigmaT": 264.0, "g": 0.0}]},
  {"name": "Blue enamel on copper", "bottom": {"kind": "conductor", "alpha": 0.15, "eta": [0.201, 0.924, 1.102], "k": [3.913, 2.453, 2.142]}, "coats": [{"alpha": 0.025, "ior": 1.55, "albedo": 0.0, "sigmaT": [1.498, 0.857, 0.239], "g": 0.0}]},
  {"name": "Green enamel on silver", "bottom": {"kind": "conductor", "alpha": 0.12, "eta": [0.155, 0.117, 0.138], "k": [4.828, 3.122, 2.147]}, "coats": [{"alpha": 0.025, "ior": 1.55, "albedo": 0.0, "sigmaT": [1.263, 0.327, 0.805], "g": 0.0}]},
  {"name": "Celadon", "bottom": {"kind": "diffuse", "reflectance": [0.66, 0.66, 0.62]}, "coats": [{"alpha": 0.04, "ior": 1.52, "albedo": [0.397, 0.659, 0.501], "sigmaT": [0.454, 0.275, 0.36], "g": 0.0}]},
  {"name": "Tenmoku", "bottom": {"kind": "diffuse", "reflectance": [0.17, 0.075, 0.035]}, "coats": [{"alpha": 0.04, "ior": 1.56, "albedo": 0.0, "sigmaT": [0.805, 1.407, 1.956], "g": 0.0}]},
  {"name": "Honey glaze", "bottom": {"kind": "diffuse", "reflectance": [0.75, 0.7, 0.62]}, "coats": [{"alpha": 0.03, "ior": 1.52, "albedo": 0.0, "sigmaT": [0.112, 0.327, 0.757], "g": 0.0}]},
  {"name": "Lacquered brass", "bottom": {"kind": "conductor", "alpha": 0.12, "eta": [0.446, 0.538, 1.02], "k": [3.52, 2.72, 1.91]}, "coats": [{"alpha": 0.06, "ior": 1.49, "albedo": 0.0, "sigmaT": [0.01, 0.031, 0.087], "g": 0.0}]},
  {"name": "Gilding under shellac", "bottom": {"kind": "conductor", "alpha": 0.2, "eta": [0.143, 0.375, 1.442], "k": [3.983, 2.386, 1.603]}, "coats": [{"alpha": 0.05, "ior": 1.516, "albedo": 0.0, "sigmaT": [0.015, 0.075, 0.239], "g": 0.0}]},
  {"name": "Anodised aluminium", "bottom": {"kind": "conductor", "alpha": 0.25, "eta": [1.658, 0.88, 0.521], "k": [9.224, 6.27, 4.837]}, "coats": [{"alpha": 0.2, "ior": 1.65, "albedo": 0.0, "sigmaT": [1.151, 0.602, 0.208], "g": 0.0}]},
  {"name": "Tarnished silver", "bottom": {"kind": "conductor", "alpha": 0.15, "eta": [0.155, 0.117, 0.138], "k": [4.828, 3.122, 2.147]}, "coats": [{"alpha": 0.2, "ior": 2.2, "albedo": [0.083, 0.048, 0.023], "sigmaT": [0.326, 0.469, 0.784], "g": 0.0}]},
  {"name": "Red nail lacquer", "bottom": {"kind": "diffuse", "reflectance": [0.72, 0.5, 0.42]}, "coats": [{"alpha": 0.02, "ior": 1.48, "albedo": [0.934, 0.095, 0.18], "sigmaT": 12.0, "g": 0.0}]},
  {"name": "Sheer pink nail lacquer", "bottom": {"kind": "diffuse", "reflectance": [0.72, 0.5, 0.42]}, "coats": [{"alpha": 0.02, "ior": 1.48, "albedo": [0.934, 0.451, 0.475], "sigmaT": [0.158, 0.312, 0.299], "g": 0.0}]},
  {"name": "Brushed chromium", "bottom": {"kind": "conductor", "alpha": 0.06, "alphaV": 0.3, "eta": [4.37, 2.917, 1.655], "k": [5.207, 4.231, 3.755]}, "coats": []},
  {"name": "Brushed copper under lacquer", "bottom": {"kind": "conductor", "alpha": 0.06, "alphaV": 0.3, "eta": [0.201, 0.924, 1.102], "k": [3.913, 2.453, 2.142]}, "coats": [{"alpha": 0.03, "ior": 1.49, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}]},
];
