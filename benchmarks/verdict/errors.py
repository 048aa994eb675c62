"""Errors E of all methods, their reciprocity, and the energy that they reflect."""

import time
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import fan2022
import numpy as np
from benchmarks import measures
from benchmarks.evaluation import benchmark, samples
from benchmarks.evaluation.distributions import Table2
from benchmarks.evaluation.samples import Group
from benchmarks.measured import coated, materials
from benchmarks.measures import error, in_plane
from benchmarks.verdict import fits
from benchmarks.verdict import methods as known
from benchmarks.verdict.methods import Values
from fan2022 import PaperNetworks
from research.rivals import weidlich

import urushi
from urushi.core import direction_sets, error_metrics
from urushi.core import table as nodes
from urushi.core.quadrature import directional_albedos
from urushi.walk import Stack
from urushi.walk.simulate import albedo as walked_albedo

#: Stacks of a number of interfaces, those of them that models are fitted to, and the seed of stacks
#: and walks, other than figure 8's.
STACKS, FITTED, SEED = 12, 4, 23
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


def isotropic(interfaces: int, paper: PaperNetworks) -> dict[str, Any]:
    """E of each method by stack, its E to the exchange of directions, and CPU seconds of a fit."""
    group = Group(f"verdict, {interfaces} interfaces", Table2(interfaces - 1), STACKS)
    held_out = benchmark.simulate(group, SEED, only_e=True)
    table, wi, wo = held_out.table, held_out.wi, held_out.wo
    methods = {name: (f, STACKS, 0.0) for name, f in known.of_stacks(held_out, paper).items()}
    tables = known.tabulated(table, FITTED)
    methods |= {name: _fits(name, tables) for name in fits.FITTED}
    own = samples.stack_errors(held_out.f + held_out.se, held_out)
    found: dict[str, Any] = {"reference": own}
    for name, (of, stacks, seconds) in methods.items():
        part = slice(stacks)
        f = of(wi[part], wo[part])
        truth, cosines = held_out.f[part], (wi[part, :, 2], wo[part, :, 2])
        exchange = 0.0
        if name not in known.ESTIMATORS:  # their noise would be all of it
            weight = error_metrics.energy_weight(*cosines)
            difference = np.abs(of(wo[part], wi[part]) - f)
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
                known.NETWORKS: replace(coated(codes, coat), table=None),
                known.TABLES: coated(tables, coat),
                known.PAPER: coated(projected, coat, fan2022.layer),
            }
            for method, e in _over_measured(urushi.coat(surface, **coat), layered).items():
                found.setdefault(method, []).append(e)
    return found


def _over_measured(stack: Stack, materials: dict[str, Any]) -> dict[str, float]:
    """E of the methods for one coat over a measured bottom; the mean over channels.

    materials: the stack as layered by methods.
    """
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(SEED), PAIRS)
    truth, se = urushi.simulate(stack, wi, wo, walks=MEASURED_WALKS, seed=SEED, progress=False)
    found = {
        "reference": error(truth + se, truth, wi, wo),
        **{form: error(m.f(wi, wo), truth, wi, wo) for form, m in materials.items()},
        known.WEIDLICH: error(weidlich.f(stack, wi, wo), truth, wi, wo),
    }
    for method, estimator in known.ESTIMATORS.items():
        f, _ = estimator.simulate(stack, wi, wo, walks=known.WALKS, seed=known.SEED)
        found[method] = error(f, truth, wi, wo)
    f, _ = urushi.simulate(
        stack, *nodes.node_pairs(), walks=MEASURED_TABLE_WALKS, seed=known.SEED, progress=False
    )
    table = fits.tabulated(f)
    for method in fits.FITTED:
        found[method] = error(fits.fitted(method, table, 3)(wi, wo), truth, wi, wo)
    return found


def laws(paper: PaperNetworks) -> dict[str, float]:
    """The largest albedo of each method over white coated stacks, which reflect at most 1.

    That of the walk is by its own directions (`urushi.walk.simulate.albedo`).
    """
    wi, found = in_plane(np.arccos(ALBEDO_COSINES)), dict[str, float]()
    pairs, walks = nodes.node_pairs(), {"walks": known.TABLE_WALKS, "seed": known.SEED}
    for alpha in WIDTHS:
        for bottom in (urushi.diffuse(1.0), urushi.conductor(alpha=alpha, r0=1.0)):
            stack, top = urushi.coat(bottom, alpha, 1.5), urushi.dielectric(alpha, 1.5)
            table = fits.tabulated(
                urushi.simulate(stack, *pairs, progress=False, **walks)[0][:, :1]
            )
            white: dict[str, fits.Brdf] = {
                known.NETWORKS: urushi.layer(top, bottom).f,
                known.PAPER: fan2022.layer(top, fan2022.encode(bottom, paper)).f,
                **{name: partial(rival.f, stack) for name, rival in known.RIVALS.items()},
                **{name: fits.fitted(name, table) for name in fits.FITTED},
            }
            albedos = {name: directional_albedos(f, wi) for name, f in white.items()}
            albedos[known.WALK], _ = walked_albedo(stack, wi, seed=SEED)
            for name, albedo in albedos.items():
                found[name] = max(found.get(name, 0.0), float(albedo[:, 0].max()))
    return found
