"""Lobes of stacks of two to six interfaces; after Figure 8 of Fan et al. 2022.

Errors over many such stacks are those of the experiment `verdict`.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.measures import in_plane
from benchmarks.showing import COLOURS, figure, table

import urushi

INTERFACES, SEED = (2, 3, 4, 5, 6), 8
#: Angles of the lobes: incident, and outgoing in the plane of incidence [degrees].
INCIDENT, OUTGOING = 45.0, np.linspace(-85.0, 85.0, 86)
#: Walks of a lobe's values, and gold's reflectance at normal incidence.
WALKS, GOLD = 1 << 15, (1.0, 0.78, 0.34)


def measure(interfaces: int, options: Options) -> Found:
    """f cos θo of gold under coats, by walk and codes; the green channel."""
    wo = in_plane(np.radians(OUTGOING))
    wi = np.repeat(in_plane([-np.radians(INCIDENT)]), len(wo), axis=0)
    stack: Any = urushi.conductor(alpha=0.12, r0=GOLD)
    for number in range(INTERFACES[0], interfaces + 1):
        # Interfaces become rougher towards the bottom.
        alpha, eta = 0.05 + 0.03 * (INTERFACES[-1] - number), 1.5 if number % 2 else 1.3
        stack = urushi.coat(stack, alpha, eta, albedo=0.7, sigma_t=0.25, g=0.4)
    f, se = urushi.simulate(stack, wi, wo, walks=options.count(WALKS, 64), seed=SEED)
    codes = replace(urushi.encode(stack, options.weights), table=None)
    values = {"walk": f, "se": se, "networks": codes.f(wi, wo)}
    return {name: value[:, 1] * wo[:, 2] for name, value in values.items()}


def plot(found: Found, _: Pictures) -> Any:
    """f cos θo over the angle in the plane of incidence."""
    picture = figure(10, 2.6)
    panels = picture.subplots(1, len(found), sharey=True)
    top = 2 * max(max(case["walk"]) for case in found.values())
    for axis, (number, case) in zip(panels, found.items(), strict=True):
        axis.plot(OUTGOING, case["walk"], color="black", linewidth=4, alpha=0.3)
        axis.plot(OUTGOING, case["networks"], color=COLOURS["networks"], linewidth=1.2)
        axis.set(yscale="log", ylim=(1e-3, top), xticks=[-90, -45, 0, 45, 90])
        axis.set(xlabel="θo [degrees]", ylabel="f cos θo [1/sr]")
        axis.set_title(f"{number} interfaces", fontsize=9)
        axis.grid(alpha=0.3)
    picture.suptitle(f"Gold under coats, θi = {INCIDENT:g}°. Grey: walk. Blue: codes.", fontsize=10)
    return picture


def tables(found: Found) -> list[str]:
    """Differences of codes from the walk, and the walk's own error, over the lobe's values."""
    rows = []
    for number, case in found.items():
        walk, se, networks = (np.array(case[name]) for name in ("walk", "se", "networks"))
        shares = np.abs(networks - walk).sum() / walk.sum(), 0.8 * se.sum() / walk.sum()
        rows.append([number, *(f"{100 * x:.2g}" for x in shares)])
    return [table(["interfaces", "E [%]: codes", "of the walk"], rows)]


EXPERIMENT = Experiment(
    lambda _: {f"{number}": number for number in INTERFACES},
    tables,
    measure,
    plot,
    models=NETWORKS,
    minutes=2,
)
