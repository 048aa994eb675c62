"""Encoding of many BRDFs: their values are computed in parallel, on all cores."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from urushi.errors import UrushiError
from urushi.material.encode import (
    SourceValues,
    encode_found,
    evaluate_source,
    model_for,
    required_pairs,
)
from urushi.material.material import Material
from urushi.material.symmetry import Deviations
from urushi.measured import load_measured
from urushi.nets.weights import Weights
from urushi.platform import available_cores


class EncodedSource(NamedTuple):
    """A material, and its source's deviations from what a material can represent."""

    material: Material
    deviations: Deviations


def encode_all(
    sources: Sequence[Any],
    *,
    weights: Weights | None = None,
    refine: bool | Sequence[bool | None] | None = None,
    table: bool | None = None,
) -> Iterator[tuple[int, EncodedSource | UrushiError]]:
    """Encode many BRDFs, on all cores of this machine.

    Args:
        sources: each a Path of a measured BRDF, or else what `encode` takes.
        weights: the networks, as of `encode`.
        refine: as of `encode`, one value for all sources or one for each.
        table: as of `encode`, for all sources.

    Yields:
        (index, EncodedSource) of each source as it is done, or its error, which stops none of the
        others.

    Raises:
        FileError: the shipped networks are missing.
    """
    models = [model_for(source, weights) for source in sources]
    wanted = list(refine) if isinstance(refine, Sequence) else [refine] * len(sources)
    tasks, places = [], []
    for index, (source, model) in enumerate(zip(sources, models, strict=True)):
        try:
            tasks.append((source, *required_pairs(source, model, table), model.widths))
            places.append(index)
        except UrushiError as error:
            yield index, error
    for task, found in map_sources(_read, tasks):
        index = places[task]
        if isinstance(found, UrushiError):
            yield index, found
            continue
        material = encode_found(sources[index], found, models[index], refine=wanted[index])
        yield index, EncodedSource(material, found.deviations)


def map_sources(function: Callable[..., Any], tasks: Sequence[tuple]) -> Iterator[tuple[int, Any]]:
    """Call a function for many sources.

    Args:
        function: is called in a thread if its source is a Path.
        tasks: the arguments of each call, of which the first is the source: a Path is read by a
            thread, for a reader uses one core; other sources one after the other, for Dr.Jit uses
            all.

    Yields:
        (index, result) of each call as it is done.
    """
    files = [k for k, task in enumerate(tasks) if isinstance(task[0], Path)]
    pool = ThreadPoolExecutor(available_cores())
    try:
        futures = {pool.submit(function, *tasks[k]): k for k in files}
        for future in as_completed(futures):
            yield futures[future], future.result()
        for k, task in enumerate(tasks):
            if k not in files:
                yield k, function(*task)
    finally:
        pool.shutdown(cancel_futures=True)


def _read(source: Any, wi: np.ndarray, wo: np.ndarray, widths: int) -> SourceValues | UrushiError:
    """Values of a source at the pairs, or its error."""
    try:
        return evaluate_source(
            load_measured(source) if isinstance(source, Path) else source, wi, wo, widths=widths
        )
    except UrushiError as error:
        return error
