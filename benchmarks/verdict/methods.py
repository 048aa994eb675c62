"""The methods of the table, and their values for rows of stacks."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from benchmarks.evaluation import fan2022 as evaluation
from benchmarks.evaluation import predict
from benchmarks.evaluation.samples import Samples, by_row, evaluate_bottoms, part
from benchmarks.verdict import fits
from fan2022 import PaperNetworks
from research import bidirectional
from research.rivals import belcour, weidlich, weier

import urushi.walk
from urushi.core import table as nodes
from urushi.nets.weights import DEFAULT, default_model
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
#: Walks of a pair, those of `urushi.simulate` by default; of a table that fits read; and a seed
#: other than that of the references.
WALKS, TABLE_WALKS, SEED = 4096, 256, 24


#: (wi, wo), both (S, M, 3) -> (S, M) [1/sr], values of the first S stacks of a table.
Values = Callable[[np.ndarray, np.ndarray], np.ndarray]


def of_stacks(held_out: Samples, paper: PaperNetworks) -> dict[str, Values]:
    """All methods but those that are fitted; networks by codes of the bottoms under coats."""
    table = held_out.table
    materials = {
        NETWORKS: predict.materials(default_model(), held_out),
        PAPER: evaluation.materials(paper, held_out),
    }
    found: dict[str, Values] = {k: partial(predict.evaluate, made) for k, made in materials.items()}
    for name, module in ESTIMATORS.items():
        walk = partial(_mean, module.walk_pairs, table, WALKS)
        found[name] = partial(_by_row, walk) if table.coats else partial(evaluate_bottoms, table)
    return found | {k: partial(_by_row, partial(m.rows, table)) for k, m in RIVALS.items()}


def tabulated(table: StackTable, stacks: int) -> list[fits.Brdf]:
    """f of the first stacks, in tables of the walk's values, which fits read."""
    wi, wo = (np.tile(w, (stacks, 1, 1)) for w in nodes.node_pairs())
    if table.coats:
        values = _by_row(partial(_mean, walk_pairs, table, TABLE_WALKS), wi, wo)
    else:
        values = evaluate_bottoms(part(table, slice(stacks)), wi, wo)
    return [fits.tabulated(own[:, None]) for own in values]


def _mean(walk: Any, table: StackTable, walks: int, *rows_and_pairs: np.ndarray) -> np.ndarray:
    return walk(table, *rows_and_pairs, walks=walks, seed=SEED)[0]


def _by_row(f: Callable[..., np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f (S, M) of a function of rows (S M,) and pairs (S M, 3)."""
    return f(*by_row(wi, wo)).reshape(wi.shape[:2])
