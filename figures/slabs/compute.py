"""Shares of the light that six slabs reflect and transmit, over the angle of incidence.

    python -m figures.slabs.compute

By walks, by the tables of `neural_layered`, and, of smooth slabs that do not scatter, in closed
form (Stokes 1862, incoherent).
"""

import functools
from pathlib import Path
from typing import Any

import numpy as np

import urushi
from figures import results
from urushi.material.slab_table import slab_tables
from urushi.nets.weights import default_model
from urushi.walk.simulate import albedo

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("slabs")
#: Angles of incidence [degrees], and those of the table.
ANGLES = (0, 10, 20, 30, 40, 50, 60, 70, 75, 80, 85)
SHOWN = (0, 40, 70)
WALKS, SEED = 1 << 16, 5

#: alpha, eta, albedo, sigma_t, g.
SLABS = {
    "window": (0.01, 1.5, 0.0, 0.0, 0.0),
    "smoked glass": (0.01, 1.5, 0.0, 0.6, 0.0),
    "frosted pane": (0.3, 1.5, 0.0, 0.0, 0.0),
    "paper": (0.5, 1.4, 0.995, 4.0, 0.3),
    "opal glass": (0.05, 1.5, 1.0, 10.0, 0.0),
    "leaf": (0.3, 1.4, 0.9, 3.0, 0.8),
}
SMOOTH = ("window", "smoked glass")


def main() -> None:
    """Compute what is missing and write results.json."""
    parts = {name: functools.partial(part, *slab) for name, slab in SLABS.items()}
    results.write(FOLDER / "results.json", results.collect(PARTS, parts))


def part(alpha: float, eta: float, medium_albedo: float, sigma_t: float, g: float) -> dict:
    """Shares of one slab at `ANGLES`: of the walk [reflected, transmitted], of the tables."""
    theta = np.radians(ANGLES)
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1).astype(np.float32)
    slab = urushi.slab(alpha, eta, medium_albedo, sigma_t, g)
    walked = [
        albedo(slab, wi, walks=WALKS, seed=SEED, transmitted=passed) for passed in (False, True)
    ]
    interfaces = np.array([[alpha, eta], [alpha, 1 / eta]])
    tables = slab_tables(default_model(), interfaces, np.array([[[medium_albedo], [sigma_t], [g]]]))
    found: dict[str, Any] = {
        "walk": [share[:, 0] for share, _ in walked],
        "se": [se[:, 0] for _, se in walked],
        "tables": np.array(tables.shares(wi))[..., 0],
    }
    return {name: results.rounded(np.array(values)) for name, values in found.items()}


def closed(eta: float, sigma_t: float, degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reflected and transmitted share of a smooth slab that absorbs."""
    cos = np.cos(np.radians(degrees))
    inside = np.sqrt(1 - (1 - cos * cos) / eta**2)
    parallel = (eta * cos - inside) / (eta * cos + inside)
    across = (cos - eta * inside) / (cos + eta * inside)
    surface = (parallel**2 + across**2) / 2
    left = np.exp(-sigma_t / inside)
    once = (1 - surface) ** 2 * left / (1 - (surface * left) ** 2)
    return surface + once * surface * left, once


if __name__ == "__main__":
    main()
