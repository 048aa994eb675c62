"""Scaling of `urushi data --cluster`: shards a second by processes and workers, and their overhead.

Rates are from the first to the last result, without the start of processes. A task of overhead
computes nothing and hands back as many bytes as a shard.
"""

import time
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
from benchmarks.experiment import Experiment, Found, Options
from benchmarks.showing import table

from urushi.train import workers
from urushi.train.tables import TableSpec, make_shard

SPEC = TableSpec(stacks=96, coats=16, probes=256, shard=4)
#: Tasks without work
EMPTY = 200


def nothing(size: int, _: int) -> np.ndarray:
    """Bytes that take no time."""
    return np.zeros(size, np.uint8)


def rate(make: Callable[[int], Any], tasks: int, cluster: str | None, processes: int) -> float:
    """Results a second."""
    found = workers.results(make, range(tasks), cluster, processes)
    next(found)
    begin = time.perf_counter()
    return sum(1 for _ in found) / (time.perf_counter() - begin)


def measured(case: tuple[str | None, int], options: Options) -> dict[str, float]:
    size = sum(x.nbytes for x in make_shard(SPEC, 0).values())
    shards = rate(partial(make_shard, SPEC), options.count(SPEC.shards(), 3), *case)
    empty = rate(partial(nothing, size), options.count(EMPTY, 9), *case)
    return {
        "shards a second": shards,
        "overhead [ms a shard]": 1e3 / empty,
        "bytes of a shard [MB]": size / 2**20,
    }


def cases(_: Options) -> dict[str, tuple[str | None, int]]:
    processes = {f"{n} process{'es' * (n > 1)}": (None, n) for n in (1, 2)}
    return processes | {f"local:{n}": (f"local:{n}", n) for n in (1, 2)}


def tables(found: Found) -> list[str]:
    names = list(next(iter(found.values())))
    rows = [[f"`{name}`", *(f"{case[x]:.3g}" for x in names)] for name, case in found.items()]
    return [table(["computed by", *names], rows)]


EXPERIMENT = Experiment(cases, tables, measured, pages=("docs/scaling.md",), minutes=6)
