"""Energy and errors of the right walk and of two faulty variants of it.

Public implementations of the walk of Guo et al. (2018) have one of two faults. The variants add
each of them to a copy of our walk; the package itself has neither. A variant draws the same random
numbers as the right walk, so that their difference has little noise.
"""

import contextlib
from collections.abc import Callable, Sequence
from functools import partial
from typing import Any
from unittest import mock

import drjit as dr
import numpy as np
from benchmarks import measures
from benchmarks.evaluation import benchmark, samples
from benchmarks.evaluation.samples import GROUPS
from benchmarks.experiment import Experiment, Found, Options, Pictures
from benchmarks.measures import in_plane
from benchmarks.showing import figure, interval, table

import urushi
from urushi.core.error_metrics import energy_weight
from urushi.walk import interface, walk
from urushi.walk.exits import ExitPaths
from urushi.walk.interface import flip
from urushi.walk.simulate import albedo

_through_top = ExitPaths.through_top


def _reverse_through_top(self: ExitPaths, w: Any) -> tuple[Any, Any]:
    """The weight of a sampled direction uses the density of leaving, not that of connecting."""
    f, _ = _through_top(self, w)
    # The faulty line: wo given the inner direction. The rival draws the inner one given wo.
    _, pdf = interface.transmission(flip(-w), flip(self._wo), self._alpha, 1 / self._eta)
    return f, pdf


def _dropping(event: Callable[..., walk.Event]) -> Callable[..., walk.Event]:
    """The event of a surface without the contribution of vertices whose sample has no weight."""

    def faulty(*arguments: Any) -> walk.Event:
        found = event(*arguments)
        # The faulty line: the walk breaks off here, before it connects.
        kept = dr.select(found.throughput > 0, found.contribution, 0)
        return found._replace(contribution=kept)

    return faulty


#: Contexts in which the walk has a fault.
reverse_density = partial(mock.patch.object, ExitPaths, "through_top", _reverse_through_top)
dropped_connection = partial(
    mock.patch.multiple,
    walk,
    bottom_event=_dropping(walk.bottom_event),
    inner_event=_dropping(walk.inner_event),
)

#: The walks by name, the right one first.
VARIANTS: dict[str, Callable[[], Any]] = {
    "right": contextlib.nullcontext,
    "reverse density": reverse_density,
    "dropped connection": dropped_connection,
}


#: GGX widths of the furnaces, and their relative index.
ALPHAS = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.14, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0)
ETA = 1.5
#: Angle of incidence [degrees], and the unit vector (1, 3) of all albedos.
INCIDENT = 30.0
WI = in_plane([np.radians(INCIDENT)])
#: Optical depths of the medium above the bottoms whose interior light is measured.
DEPTHS = (0.0, 1.0)
#: Width of the coat above them.
COAT_ALPHA = 0.1
#: Walks of an albedo, and of a pair of directions.
WALKS, PAIR_WALKS = 1 << 22, 1 << 15
SEED = 11
#: The held-out stacks of the paper's Table 2 in the stored benchmark set.
STACKS = tuple(group for group in GROUPS if group.name == "two, table2")


def mirror(alpha: float, coat: float, depth: float) -> Any:
    """A mirror under a coat of a medium that absorbs nothing."""
    return urushi.coat(urushi.conductor(alpha, r0=1), coat, ETA, albedo=1, sigma_t=depth)


def furnace(options: Options) -> Found:
    """Directional albedo of clear coats over equally rough mirrors."""
    return albedos([mirror(alpha, alpha, 0) for alpha in ALPHAS], options)


def interior(options: Options) -> Found:
    """Directional albedo of rough mirrors below a coat without absorption; `top` is its surface's.

    One list for each of `DEPTHS`.
    """
    found: Found = {
        f"depth {depth:g}": albedos([mirror(alpha, COAT_ALPHA, depth) for alpha in ALPHAS], options)
        for depth in DEPTHS
    }
    black = urushi.coat(urushi.diffuse(0), COAT_ALPHA, ETA, albedo=0, sigma_t=0)
    return found | {"top": albedos([black], options)["right"]["albedo"][0]}


def albedos(stacks: Sequence[Any], options: Options) -> Found:
    """Albedo of every stack, by the walk's name; standard errors are about 0.1 %."""
    found, walk = {}, partial(albedo, walks=options.count(WALKS, 1 << 10), seed=SEED)
    for name, variant in VARIANTS.items():
        with variant():
            found[name] = {"albedo": [walk(stack, WI)[0][0, 0] for stack in stacks]}
    return found


def table2(options: Options) -> Found:
    """How far each fault would move the values of Table 2 stacks; by the fault's name.

    E is the error of the faulty value, `energy` the relative change of sum f cos cos, both over the
    pairs of the stored set. The two walks share their random numbers. `noise` is E of the right
    walk against the stored values.
    """
    (stored,) = benchmark.read(groups=STACKS).values()
    part = slice(None), slice(None, samples.E_PAIRS)
    wi, wo, values = stored.wi[part], stored.wo[part], {}
    for name, variant in VARIANTS.items():
        with variant():
            walks = options.count(PAIR_WALKS, 64)
            values[name], _ = samples.walk_all(stored.table, wi, wo, walks, SEED)
    reference = values.pop("right")
    error = partial(measures.stack_error, cos_i=wi[..., 2], cos_o=wo[..., 2])
    weight = energy_weight(wi[..., 2], wo[..., 2])
    found: Found = {"noise": error(reference, stored.f[part])}
    for name, f in values.items():
        change = (weight * (f - reference)).sum(1) / (weight * reference).sum(1)
        found[name] = {"E": error(f, reference), "energy": change}
    return found


#: The faults in the order of the table, with their colours.
FAULTS = {"reverse density": "#d55e00", "dropped connection": "#0072b2"}


def plot(found: Found, _: Pictures) -> Any:
    """White furnaces, the change of the light that was below a coat, and sorted E of stacks."""
    picture = figure(12, 3.6)
    axes = white, inside, stacks = picture.subplots(1, 3)
    white.axhline(1, color="#999999", linewidth=0.8)
    for name, colour in {"right": "#000000", **FAULTS}.items():
        # Standard errors are smaller than the markers.
        look = {"color": colour, "linewidth": 4 if name == "right" else 1.2, "markersize": 3}
        white.plot(ALPHAS, found["furnace_alpha"][name]["albedo"], "o-", **look, label=name)
    white.set(xscale="log", xlabel="alpha of both surfaces")
    white.set_ylabel(f"integral of f cos θo, θi = {INCIDENT:g}°")
    white.set_title(f"white furnace, clear coat of eta {ETA:g} over a mirror", fontsize=10)
    for depth, line in zip(DEPTHS, ("-", "--"), strict=True):
        part, medium = found["interior"][f"depth {depth:g}"], f"depth {depth:g}"
        for name, colour in FAULTS.items():
            right, faulty = (np.array(part[walk]["albedo"]) for walk in ("right", name))
            change = 100 * (faulty - right) / (right - found["interior"]["top"])
            label = f"{name}, {medium if depth else 'no medium'}"
            inside.plot(ALPHAS, change, line, color=colour, label=label)
    inside.set(xscale="log", xlabel="alpha of the mirror", ylabel="change of interior light [%]")
    inside.set_title(f"mirror under a coat of alpha {COAT_ALPHA:g}", fontsize=10)
    table_2 = found["table2"]
    for name, colour in FAULTS.items():
        errors = 100 * np.sort(table_2[name]["E"])
        share = 100 * (np.arange(len(errors)) + 0.5) / len(errors)
        stacks.plot(np.maximum(errors, 1e-3), share, color=colour, label=name)
    noise, label = 100 * np.mean(table_2["noise"]), "right walk against stored values"
    stacks.axvline(noise, color="#999999", linestyle=":", label=label)
    stacks.set(xscale="log", xlabel="E [%], at least 0.001", ylabel="stacks with a smaller E [%]")
    stacks.set_title(f"{len(table_2['noise'])} stacks of Table 2", fontsize=10)
    for axis, place in zip(axes, ("best", "best", "upper left"), strict=True):
        axis.legend(fontsize=8, loc=place)
        axis.grid(alpha=0.3)
    return picture


def tables(found: Found) -> list[str]:
    """A table: E and the change of energy over the stacks of Table 2."""
    head = ["fault", "E, mean (95 % interval)", "median", "largest", "reflected energy, mean"]
    rows = []
    for name in FAULTS if "table2" in found else ():
        errors = 100 * np.array(found["table2"][name]["E"])
        energy = 100 * np.mean(found["table2"][name]["energy"])
        low, high = interval(errors)
        mean = f"{errors.mean():.2g} % ({low:.2g} to {high:.2g})"
        others = f"{np.median(errors):.2g} %", f"{errors.max():.2g} %", f"{energy:+.2g} %"
        rows.append([name, mean, *others])
    return [table(head, rows)]


EXPERIMENT = Experiment(
    cases=lambda _: {"furnace_alpha": furnace, "interior": interior, "table2": table2},
    tables=tables,
    plot=plot,
    pages=("docs/simulator_biases.md",),
    minutes=2,
)
