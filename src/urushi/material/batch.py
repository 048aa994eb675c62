"""Encoding many BRDFs at once: their values are taken in parallel, by all cores or a cluster."""

import os
from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

import numpy as np

from urushi.data import cluster
from urushi.errors import UrushiError
from urushi.material.encode import encode_values, seen_pairs, values_at
from urushi.material.material import Material
from urushi.measured import load_measured
from urushi.nets import shipped
from urushi.nets.shipped import Weights


def encode_all(
    sources: Sequence[Any],
    *,
    model: Weights | None = None,
    scheduler: str | None = None,
    refine: bool = False,
) -> Iterator[tuple[int, Material | UrushiError]]:
    """Encode many BRDFs, on all cores of this machine or on a cluster.

    Args:
        sources: each a Path of a measured BRDF, which whoever reads it must reach, or else what
            `encode` takes; on a cluster it must be picklable, as descriptions are.
        model: the networks, as of `encode`.
        scheduler: address of a Dask scheduler; by default this process does it, on all cores.
        refine: as of `encode`; this process does it.

    Yields:
        (index, Material) of each source as it is done, or the error that it has, which stops none
        of the others.

    Raises:
        PlatformError: there is no such scheduler.
        FileError: the shipped networks are missing.
    """
    model = shipped.find(model)
    tasks = [(source, *seen_pairs(source, model)) for source in sources]
    results = cluster.run(scheduler, _values, tasks) if scheduler else _locally(tasks)
    for index, values in results:
        failed = isinstance(values, UrushiError)
        yield index, values if failed else encode_values(values, model, refine=refine)


def _values(source: Any, wi: np.ndarray, wo: np.ndarray) -> np.ndarray | UrushiError:
    """A source's values (N, C) at the pairs, or what is wrong with it."""
    try:
        return values_at(load_measured(source) if isinstance(source, Path) else source, wi, wo)
    except UrushiError as error:
        return error


def _locally(tasks: list[tuple]) -> Iterator[tuple[int, Any]]:
    """Files in threads, for a reader uses one core; the rest here, for Dr.Jit uses all."""
    files = [k for k, task in enumerate(tasks) if isinstance(task[0], Path)]
    pool = ThreadPoolExecutor(os.cpu_count())
    try:
        futures = {pool.submit(_values, *tasks[k]): k for k in files}
        for future in as_completed(futures):
            yield futures[future], future.result()
        for k, task in enumerate(tasks):
            if k not in files:
                yield k, _values(*task)
    finally:
        pool.shutdown(cancel_futures=True)
