"""The methods of the table, and their values for rows of stacks."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from benchmarks.evaluation import benchmark_set, predict, samples
from benchmarks.evaluation import fan2022 as evaluation
from benchmarks.evaluation.samples import Samples
from benchmarks.verdict import fits
from fan2022 import PaperNetworks
from research import bidirectional
from research.rivals import belcour, weidlich, weier

import urushi.walk
from urushi.core import table as nodes
from urushi.nets.weights import DEFAULT, Model
from urushi.walk import StackTable, walk_pairs

NETWORKS, PAPER = "networks", "Fan et al. 2022"
WALK, BOTH_WAYS = "walk", "walk, bidirectional"
BELCOUR, WEIER = "Belcour 2018", "Weier and Belcour 2020"
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
RIVALS = {BELCOUR: belcour, WEIER: weier, WEIDLICH: weidlich}
#: Rows of the table; that of `PAPER` needs a weights file.
METHODS = (NETWORKS, PAPER, WALK, BOTH_WAYS, BELCOUR, WEIER, WEIDLICH, *fits.FITTED)
#: Walks of a pair, those of `urushi.simulate` by default; of a table that fits read; and a seed
#: other than that of the references.
WALKS, TABLE_WALKS, SEED = 4096, 256, 24


class Values(NamedTuple):
    """Values of a method for the first stacks of a table.

    Attributes:
        stacks: their number S.
        f: (wi, wo), both (S, M, 3) -> (S, M) [1/sr].
        seconds: CPU time of a fit [s]; 0 if there is none.
    """

    stacks: int
    f: Callable[[np.ndarray, np.ndarray], np.ndarray]
    seconds: float = 0.0


def of_networks(model: Model, held_out: Samples) -> Values:
    """Codes of the bottoms under coats by light transport."""
    materials = predict.materials(model, held_out)
    return Values(len(materials), lambda wi, wo: predict.evaluate(materials, wi, wo))


def of_paper(networks: PaperNetworks, held_out: Samples) -> Values:
    """The same by the system of Fan et al. (2022)."""
    materials = evaluation.materials(networks, held_out)
    return Values(len(materials), lambda wi, wo: predict.evaluate(materials, wi, wo))


def of_walk(table: StackTable, name: str) -> Values:
    """The walk by one of `ESTIMATORS`; exact for stacks without coats."""

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        if not table.coats:
            return samples.evaluate_bottoms(table, wi, wo)
        return _by_row(
            wi,
            wo,
            lambda row, wi, wo: ESTIMATORS[name].walk_pairs(
                table, row, wi, wo, walks=WALKS, seed=SEED
            )[0],
        )

    return Values(len(table), f)


def of_rival(table: StackTable, name: str) -> Values:
    """One of `RIVALS`."""
    rival = RIVALS[name]
    return Values(
        len(table),
        lambda wi, wo: _by_row(wi, wo, lambda row, wi, wo: rival.rows(table, row, wi, wo)),
    )


def tabulated(table: StackTable, stacks: int) -> list[fits.Brdf]:
    """f of the first stacks, in tables of the walk's values, which fits read."""
    wi, wo = (np.tile(w, (stacks, 1, 1)) for w in nodes.node_pairs())
    if table.coats:
        values = _by_row(
            wi,
            wo,
            lambda row, wi, wo: walk_pairs(table, row, wi, wo, walks=TABLE_WALKS, seed=SEED)[0],
        )
    else:
        values = samples.evaluate_bottoms(benchmark_set.first(table, stacks), wi, wo)
    return [fits.tabulated(own[:, None]) for own in values]


def _by_row(
    wi: np.ndarray, wo: np.ndarray, f: Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """f (S, M) of a function of rows (S M,) and pairs (S M, 3)."""
    row = np.repeat(np.arange(len(wi), dtype=np.uint32), wi.shape[1])
    return f(row, wi.reshape(-1, 3), wo.reshape(-1, 3)).reshape(wi.shape[:2])
