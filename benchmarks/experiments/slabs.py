"""Shares of the light that six slabs reflect and transmit, over the angle of incidence.

By walks, by the tables of `neural_layered`, and, of smooth slabs that do not scatter, in closed
form (Stokes 1862, incoherent).
"""

from typing import Any

import numpy as np
from benchmarks.experiment import Experiment, Found, Options, Pictures
from benchmarks.measures import in_plane
from benchmarks.showing import COLOURS, figure, table

import urushi
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.material.slab_table import slab_tables
from urushi.walk.simulate import albedo

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


def measure(slab: tuple[float, ...], options: Options) -> Found:
    """Shares of one slab at `ANGLES`: of the walk [reflected, transmitted], of the tables."""
    wi, (alpha, eta, *medium) = in_plane(np.radians(ANGLES)), slab
    described, walks = urushi.slab(*slab), options.count(WALKS, 1 << 10)
    walked = [
        albedo(described, wi, walks=walks, seed=SEED, transmitted=passed)
        for passed in (False, True)
    ]
    interfaces = np.array([[alpha, eta], [alpha, 1 / eta]])
    by_tables = slab_tables(interfaces, np.reshape(medium, (1, 3, 1)))
    return {
        "walk": [share[:, 0] for share, _ in walked],
        "se": [se[:, 0] for _, se in walked],
        "tables": np.array(by_tables.shares(wi))[..., 0],
    }


def closed(eta: float, sigma_t: float, degrees: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Reflected and transmitted share of a smooth slab that absorbs."""
    surface, inside = fresnel.dielectric(np.cos(np.radians(degrees)), eta, NUMPY)
    left = np.exp(-sigma_t / inside)
    once = (1 - surface) ** 2 * left / (1 - (surface * left) ** 2)
    return surface + once * surface * left, once


#: Labels and colours of the two shares.
SHARES = (("reflected", COLOURS["principled"]), ("transmitted", COLOURS["networks"]))


def plot(found: Found, _: Pictures) -> Any:
    """Both shares of each slab."""
    picture = figure(10, 6)
    for axis, (name, slab) in zip(picture.subplots(2, 3).ravel(), SLABS.items(), strict=True):
        for number, (label, colour) in enumerate(SHARES):
            walk, by_table = (found[name][kind][number] for kind in ("walk", "tables"))
            axis.plot(ANGLES, walk, "o", color=colour, markersize=4, label=f"{label}, walk")
            axis.plot(ANGLES, by_table, "-", color=colour, label=f"{label}, table")
            if name in SMOOTH:
                fine = np.linspace(0, 89, 90)
                share = closed(slab[1], slab[3], fine)[number]
                axis.plot(fine, share, ":", color="#000000", label="closed form")
        axis.set(ylim=(0, 1), xlabel="angle of incidence [°]", title=name)
        axis.grid(alpha=0.3)
        if name == SMOOTH[0]:
            axis.legend(fontsize=7)
    return picture


def tables(found: Found) -> list[str]:
    """A table: reflected and transmitted share by walk and table, at a few angles."""
    head = ["slab", *(f"{angle}°: walk; table" for angle in SHOWN)]

    def cell(case: Found, at: int) -> str:
        walk, tables = (
            " + ".join(f"{100 * share[at]:.1f}" for share in case[kind])
            for kind in ("walk", "tables")
        )
        return f"{walk}; {tables} %"

    places = [ANGLES.index(angle) for angle in SHOWN]
    rows = [[name, *(cell(case, at) for at in places)] for name, case in found.items()]
    return [table(head, rows)]


EXPERIMENT = Experiment(
    cases=lambda _: SLABS, measure=measure, tables=tables, plot=plot, pages=("docs/slabs.md",)
)
