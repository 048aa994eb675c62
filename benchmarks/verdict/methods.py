"""The methods of the table: errors E, reciprocity, and the energy that they reflect."""

import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import fan2022
import numpy as np
from benchmarks import measures
from benchmarks.evaluation import benchmark, predict, samples
from benchmarks.evaluation import fan2022 as evaluation
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group, Samples
from benchmarks.measures import error, in_plane
from benchmarks.subjects import coated, materials
from benchmarks.verdict import fits
from fan2022 import PaperNetworks
from research import bidirectional
from research.rivals import belcour, weidlich

import urushi.walk
from urushi.core import direction_sets, error_metrics
from urushi.core import table as nodes
from urushi.core.quadrature import directional_albedos
from urushi.nets.weights import DEFAULT, default_model
from urushi.walk import Stack, StackTable, walk_pairs
from urushi.walk.simulate import albedo as walked_albedo

NETWORKS, PAPER = "networks", "Fan et al. 2022"
WALK, BOTH_WAYS = "walk", "walk, bidirectional"
BELCOUR = "Belcour 2018"  # for one width, Weier and Belcour 2020 is the same
WEIDLICH = "Weidlich and Wilkie 2007"
#: What `urushi.layer` makes over measured materials that have tables; `NETWORKS` are codes.
TABLES = "tables"
#: Plugins of the methods that Mitsuba renders.
PLUGINS = {
    NETWORKS: DEFAULT,
    WALK: "layered",
    BELCOUR: "layered_belcour",
    WEIDLICH: "layered_weidlich",
}
#: Modules' functions `simulate` and `walk_pairs`, by method.
ESTIMATORS = {WALK: urushi.walk, BOTH_WAYS: bidirectional}
RIVALS = {BELCOUR: belcour, WEIDLICH: weidlich}
#: Walks of a pair, those of `urushi.simulate` by default; of a table that fits read; and a seed
#: other than that of the references.
WALKS, TABLE_WALKS, SEED = 4096, 256, 24
#: Stacks of a number of interfaces, those of them that models are fitted to, and the seed of stacks
#: and walks, other than figure 8's.
STACKS, FITTED, DRAWN = 12, 4, 23
#: Pairs of directions over measured bottoms.
PAIRS = 100
#: White stacks: widths of the coat, and cosines at which their albedo is measured.
WIDTHS, ALBEDO_COSINES = (0.1, 0.5), (0.1, 0.3, 0.6, 1.0)
#: Measured bottoms, and the coats over them.
BOTTOMS = 3
OVER: tuple[dict[str, Any], ...] = (
    {"alpha": 0.1, "eta": 1.5, "albedo": 0.0, "sigma_t": (0.1, 0.4, 1.2)},
    {"alpha": 0.1, "eta": 1.4, "albedo": (0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3},
)
#: Walks of a pair of the reference over measured bottoms, and of a table that fits read.
MEASURED_WALKS, MEASURED_TABLE_WALKS = 1 << 13, 64

#: (wi, wo), both (S, M, 3) -> (S, M) [1/sr], values of the first S stacks of a table.
Values = Callable[[np.ndarray, np.ndarray], np.ndarray]


def of_stacks(held_out: Samples, paper: PaperNetworks) -> dict[str, Values]:
    """All methods but those that are fitted; networks by codes of the bottoms under coats."""
    table = held_out.table
    made = {
        NETWORKS: predict.materials(default_model(), held_out),
        PAPER: evaluation.materials(paper, held_out),
    }
    found: dict[str, Values] = {k: partial(predict.evaluate, own) for k, own in made.items()}
    for name, module in ESTIMATORS.items():
        found[name] = partial(_walked, table, WALKS, module.walk_pairs)
    return found | {name: partial(_rival, module, table) for name, module in RIVALS.items()}


def _walked(table: StackTable, walks: int, walk: Any, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return samples.walk_all(table, wi, wo, walks, SEED, walk)[0]


def _rival(module: Any, table: StackTable, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    return module.rows(table, *samples.by_row(wi, wo)).reshape(wi.shape[:2])


def isotropic(interfaces: int, paper: PaperNetworks) -> dict[str, Any]:
    """E of each method by stack, its E to the exchange of directions, and CPU seconds of a fit."""
    group = Group(f"verdict, {interfaces} interfaces", Table2(interfaces - 1), STACKS)
    held_out = benchmark.simulate(group, DRAWN, only_e=True)
    table, wi, wo = held_out.table, held_out.wi, held_out.wo
    methods = {name: (f, STACKS, 0.0) for name, f in of_stacks(held_out, paper).items()}
    # Fits read tables of the walk's values of the first stacks.
    nodes_of = (np.tile(w, (FITTED, 1, 1)) for w in nodes.node_pairs())
    values = _walked(table, TABLE_WALKS, walk_pairs, *nodes_of)
    tables = [fits.tabulated(own[:, None]) for own in values]
    methods |= {name: _fits(name, tables) for name in fits.FITTED}
    own = samples.stack_errors(held_out.f + held_out.se, held_out)
    found: dict[str, Any] = {"reference": own}
    for name, (of, stacks, seconds) in methods.items():
        first = slice(stacks)
        f = of(wi[first], wo[first])
        truth, cosines = held_out.f[first], (wi[first, :, 2], wo[first, :, 2])
        exchange = 0.0
        if name not in ESTIMATORS:  # their noise would be all of it
            weight = error_metrics.energy_weight(*cosines)
            difference = np.abs(of(wo[first], wi[first]) - f)
            exchange = float((difference * weight).sum() / (f * weight).sum())
        found[name] = {
            "E": measures.stack_error(f, truth, *cosines),
            "exchange": exchange,
            "seconds": seconds,
        }
    return found


def _fits(name: str, tables: list[fits.Brdf]) -> tuple[Values, int, float]:
    """A model fitted to each stack, their number, and CPU seconds of a fit."""
    begin = time.process_time()
    models = [fits.fitted(name, f) for f in tables]
    seconds = (time.process_time() - begin) / len(models)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        both = zip(models, wi, wo, strict=True)
        return np.stack([model(*pair)[:, 0] for model, *pair in both])

    return f, len(models), seconds


def measured(archive: Path, paper: PaperNetworks) -> dict[str, Any]:
    """E of the methods that take any bottom, over stand-ins for measured materials under coats."""
    members = sorted(materials([archive]), key=lambda member: member.name)
    chosen = members[:: max(len(members) // BOTTOMS, 1)][:BOTTOMS]
    found: dict[str, Any] = {"materials": [member.name for member in chosen]}
    for member in chosen:
        surface = member.load()
        codes, tables = urushi.encode(surface, table=False), urushi.encode(surface)
        projected = fan2022.encode(surface, paper)
        for coat in OVER:
            layered = {
                NETWORKS: replace(coated(codes, coat), table=None).f,
                TABLES: coated(tables, coat).f,
                PAPER: coated(projected, coat, fan2022.layer).f,
            }
            for method, e in _over_measured(urushi.coat(surface, **coat), layered).items():
                found.setdefault(method, []).append(e)
    return found


def _over_measured(stack: Stack, methods: dict[str, fits.Brdf]) -> dict[str, float]:
    """E of the methods for one coat over a measured bottom; the mean over channels.

    methods: those by which the stack has been layered.
    """
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(DRAWN), PAIRS)
    walk: dict[str, Any] = {"seed": SEED, "progress": False}
    truth, se = urushi.simulate(stack, wi, wo, walks=MEASURED_WALKS, seed=DRAWN, progress=False)
    f, _ = urushi.simulate(stack, *nodes.node_pairs(), walks=MEASURED_TABLE_WALKS, **walk)
    table = fits.tabulated(f)
    found = {"reference": truth + se} | {name: f(wi, wo) for name, f in methods.items()}
    found[WEIDLICH] = weidlich.f(stack, wi, wo)
    for name, estimator in ESTIMATORS.items():
        found[name], _ = estimator.simulate(stack, wi, wo, walks=WALKS, seed=SEED)
    found |= {name: fits.fitted(name, table, 3)(wi, wo) for name in fits.FITTED}
    return {name: error(f, truth, wi, wo) for name, f in found.items()}


def laws(paper: PaperNetworks) -> dict[str, float]:
    """The largest albedo of each method over white coated stacks, which reflect at most 1.

    That of the walk is by its own directions (`urushi.walk.simulate.albedo`).
    """
    wi, found = in_plane(np.arccos(ALBEDO_COSINES)), dict[str, float]()
    pairs, walks = nodes.node_pairs(), {"walks": TABLE_WALKS, "seed": SEED}
    for alpha in WIDTHS:
        for bottom in (urushi.diffuse(1.0), urushi.conductor(alpha=alpha, r0=1.0)):
            stack, top = urushi.coat(bottom, alpha, 1.5), urushi.dielectric(alpha, 1.5)
            table = fits.tabulated(
                urushi.simulate(stack, *pairs, progress=False, **walks)[0][:, :1]
            )
            white: dict[str, fits.Brdf] = {
                NETWORKS: urushi.layer(top, bottom).f,
                PAPER: fan2022.layer(top, fan2022.encode(bottom, paper)).f,
                **{name: partial(rival.f, stack) for name, rival in RIVALS.items()},
                **{name: fits.fitted(name, table) for name in fits.FITTED},
            }
            albedos = {name: directional_albedos(f, wi) for name, f in white.items()}
            albedos[WALK], _ = walked_albedo(stack, wi, seed=DRAWN)
            for name, albedo in albedos.items():
                found[name] = max(found.get(name, 0.0), float(albedo[:, 0].max()))
    return found
