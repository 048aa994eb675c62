"""Golden vectors: values of Urushi in Python, with which those of the page's core are compared.

    python viewer/tests/golden.py default anisotropic

writes these, or those that are named:

- `default_vectors.safetensors`: values by the shipped basis and its networks;
- `anisotropic_vectors.safetensors`: the same for two GGX widths.

Parameters are of double precision here, as in the core: in single precision, codes and f differ by
some 1e-6, which would hide errors of that size. The files lie beside the tests of the core. Run the
script again when the weights or their definition change.
"""

import dataclasses
import sys
from pathlib import Path
from typing import Any

import numpy as np

import urushi
from urushi import files
from urushi.core.direction_sets import cosine_pairs, half_angle_pairs
from urushi.core.directions import turned
from urushi.material.material import Material
from urushi.nets import weights

FOLDER = Path(__file__).parent / "core" / "golden"

CLEAR = {"alpha": 0.05, "ior": 1.5, "albedo": 0.0, "sigmaT": 0.0, "g": 0.0}
RED = {"alpha": 0.2, "ior": 1.45, "albedo": [0.9, 0.4, 0.2], "sigmaT": [0.8, 2.0, 3.0], "g": 0.3}
MILKY = {"alpha": 0.4, "ior": 1.33, "albedo": 0.98, "sigmaT": 1.5, "g": [0.0, 0.4, -0.6]}
LOW = {"alpha": 0.15, "ior": 0.75, "albedo": 0.5, "sigmaT": 0.3, "g": 0.0}
SHARP = {"alpha": 0.01, "ior": 1.7, "albedo": 0.2, "sigmaT": 0.05, "g": 0.9}
FAINT = {"alpha": 0.1, "ior": 1.025, "albedo": 0.5, "sigmaT": [0.0, 0.01, 1.0], "g": 0.0}
DEEP = {
    "alpha": 0.1,
    "ior": 1.4,
    "albedo": [1.0, 0.99, 0.9],
    "sigmaT": [50.0, 20.0, 13.0],
    "g": 0.5,
}
FORWARD = {"alpha": 0.1, "ior": 1.4, "albedo": 0.9, "sigmaT": 4.0, "g": [0.98, -0.95, 0.7]}
GOLD = {"kind": "conductor", "alpha": 0.15, "eta": [0.14, 0.37, 1.44], "k": [4.1, 2.4, 1.6]}
METAL = {"kind": "conductor", "alpha": [0.1, 0.2, 0.3], "r0": [0.9, 0.6, 0.3]}
GLASS = {"kind": "dielectric", "alpha": 0.3, "ior": 1.52}
PAINT = {"kind": "diffuse", "reflectance": [0.8, 0.3, 0.05]}
WHITE = {"kind": "diffuse", "reflectance": 1.0}

#: Stacks in the page's terms, the topmost coat first, with absolute indices.
STACKS: list[dict[str, Any]] = [
    {"bottom": GOLD, "coats": []},
    {"bottom": METAL, "coats": []},
    {"bottom": GLASS, "coats": []},
    {"bottom": PAINT, "coats": []},
    {"bottom": GOLD, "coats": [CLEAR]},
    {"bottom": METAL, "coats": [LOW]},
    {"bottom": PAINT, "coats": [SHARP]},
    {"bottom": WHITE, "coats": [MILKY]},
    {"bottom": GLASS, "coats": [RED, CLEAR]},
    {"bottom": WHITE, "coats": [SHARP, CLEAR, MILKY]},
    {"bottom": METAL, "coats": [FAINT]},
    {"bottom": PAINT, "coats": [FAINT, CLEAR]},
    {"bottom": PAINT, "coats": [DEEP]},
    {"bottom": GOLD, "coats": [FORWARD]},
    {"bottom": METAL, "coats": [CLEAR, CLEAR]},  # equal indices: no interface between them
    {"bottom": GOLD, "coats": [CLEAR, MILKY | {"ior": 1.5}]},
    {"bottom": PAINT, "coats": [LOW, MILKY, RED, CLEAR, MILKY, SHARP]},
]

BRUSHED = GOLD | {"alphaV": 0.03}
SATIN_METAL = METAL | {"alphaV": [0.4, 0.2, 0.05]}
SATIN = RED | {"alphaV": 0.05}
LOW_SATIN = LOW | {"alphaV": 0.5}
FAINT_SATIN = FAINT | {"alphaV": 0.3}

#: Stacks of surfaces with two widths, beside isotropic ones.
ANISOTROPIC_STACKS: list[dict[str, Any]] = [
    {"bottom": BRUSHED, "coats": []},
    {"bottom": SATIN_METAL, "coats": []},
    {"bottom": PAINT, "coats": []},
    {"bottom": GLASS | {"alphaV": 0.06}, "coats": [CLEAR]},
    {"bottom": BRUSHED, "coats": [CLEAR]},
    {"bottom": WHITE, "coats": [SATIN]},
    {"bottom": SATIN_METAL, "coats": [LOW_SATIN]},
    {"bottom": BRUSHED, "coats": [SATIN, MILKY]},
    {"bottom": SATIN_METAL, "coats": [FAINT_SATIN]},
    {"bottom": PAINT, "coats": [SHARP, SATIN, CLEAR]},
]

#: Pairs of directions; cosines of the albedo; cosines and directions of each of the proposal.
PAIRS, COSINES, DRAWN_COSINES, DRAWN = 64, (1.0, 0.7, 0.3, 0.05), 4, 16


def material_of(stack: dict[str, Any], model: weights.Model) -> Material:
    """The codes of a stack by the layering network."""
    numbers = stack["bottom"]
    others = {key: value for key, value in numbers.items() if "alpha" not in key and key != "kind"}
    material = getattr(urushi, numbers["kind"])(**widths_of(numbers), **others)
    for coat in reversed(stack["coats"]):
        top = urushi.dielectric(ior=coat["ior"], **widths_of(coat))
        medium = {"albedo": coat["albedo"], "sigma_t": coat["sigmaT"], "g": coat["g"]}
        material = urushi.layer(top, material, **medium, weights=model, fast=True)
    return urushi.encode(material, model)


def widths_of(numbers: dict[str, Any]) -> dict[str, Any]:
    """The GGX widths of a surface in the page's terms as arguments of Urushi's functions."""
    if "alphaV" in numbers:
        return {"alpha_u": numbers["alpha"], "alpha_v": numbers["alphaV"]}
    return {"alpha": numbers["alpha"]} if "alpha" in numbers else {}


def write_vectors(name: str, model: weights.Model) -> None:
    """Write the vectors of all stacks."""
    double = {name: values.astype(np.float64) for name, values in model.params.items()}
    model = dataclasses.replace(model, params=double)
    stacks = STACKS if model.widths == 1 else ANISOTROPIC_STACKS
    materials = [material_of(stack, model) for stack in stacks]
    wi, wo = pairs_of(model.widths)
    wo[-1, 2] *= -1  # below the horizon
    cosines = np.array(COSINES, np.float32)
    incident = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
    arrays = {
        "wi": wi,
        "wo": wo,
        "cosines": cosines,
        "latents": np.stack([material.latents for material in materials]),
        "f": np.stack([values_of(material, wi, wo) for material in materials]).astype(np.float32),
        "albedo": np.stack([m.directional_albedo(incident) for m in materials]),
        "drawn": np.stack([_drawn(material) for material in materials]),
    }
    description = {"stacks": stacks, "weights": model.fingerprint}
    files.write_tensors(FOLDER / f"{name}_vectors.safetensors", "vectors", description, arrays)


def pairs_of(widths: int) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of directions (`PAIRS`, 3); for anisotropic networks at all azimuths."""
    rng = np.random.default_rng(3)
    sets = (draw(rng, PAIRS // 2, lowest_cosine=0.004) for draw in (half_angle_pairs, cosine_pairs))
    wi, wo = (np.concatenate(sides) for sides in zip(*sets, strict=True))
    if widths == 2:
        azimuths = rng.uniform(0, 2 * np.pi, PAIRS)
        wi, wo = (turned(w.astype(np.float64), azimuths).astype(np.float32) for w in (wi, wo))
    return wi, wo


def values_of(material: Material, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """`material.f` in double precision: single loses digits for indices close to 1."""
    codes, wi, wo = (array.astype(np.float64) for array in (material.latents, wi, wo))
    f = material.model.networks.f(codes[None], wi[:, None], wo[:, None])
    return np.where((wi[:, 2:] > 0) & (wo[:, 2:] > 0), f, 0.0)


def _drawn(material: Material) -> np.ndarray:
    """Directions and densities (cosines, `DRAWN`, 4) by the sequence of the page's table."""
    base = 2.0
    for _ in range(64):  # the root of x^4 = x + 1: Roberts' R sequence (2018)
        base = (1.0 + base) ** 0.25
    steps = base ** -np.arange(1.0, 4.0)
    u = (0.5 + np.arange(1, DRAWN + 1)[:, None] * steps) % 1.0
    rows = []
    for row in range(DRAWN_COSINES):
        cosine = (row + 0.5) / DRAWN_COSINES
        wi = np.tile([np.sqrt(1 - cosine * cosine), 0, cosine], (DRAWN, 1)).astype(np.float32)
        wo, pdf = material.sample(wi, u)
        rows.append(np.column_stack([wo, pdf]))
    return np.stack(rows).astype(np.float32)


#: What the script writes, by name.
WRITERS = {
    "default": lambda: write_vectors("default", weights.default_model()),
    "anisotropic": lambda: write_vectors("anisotropic", weights.anisotropic_model()),
}


def main() -> None:
    """Write the files that are named."""
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:]:
        WRITERS[name]()


if __name__ == "__main__":
    main()
