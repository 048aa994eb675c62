"""Encoding of many BRDFs: measured files are read in parallel, on all cores."""

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from urushi.errors import UrushiError
from urushi.material.encode import (
    SourceValues,
    encode_found,
    encode_source,
    evaluate_source,
    model_for,
    required_pairs,
)
from urushi.material.material import Material
from urushi.material.symmetry import Deviations
from urushi.measured import load_measured
from urushi.nets.weights import Weights
from urushi.platform import available_cores


def encode_all(
    sources: Sequence[Any],
    *,
    weights: Weights | None = None,
    refine: bool | None = None,
    table: bool | None = None,
) -> Iterator[tuple[int, tuple[Material, Deviations] | UrushiError]]:
    """Encode many BRDFs, on all cores of this machine.

    A file is read by one thread; other sources follow one after the other, because Dr.Jit uses all
    cores.

    Args:
        sources: each a Path of a measured BRDF, or else what `encode` takes.
        weights, refine, table: as of `encode`.

    Yields:
        (index, result) of each source as it is done: the material, and the source's deviations from
        what a material can represent; or the source's error, which stops none of the others.
    """
    models = [model_for(source, weights) for source in sources]

    def read(index: int) -> SourceValues | UrushiError:
        try:
            pairs = required_pairs(sources[index], models[index], table)
            opened = load_measured(sources[index])
            return evaluate_source(opened, *pairs, widths=models[index].widths)
        except UrushiError as error:
            return error

    files = [k for k, source in enumerate(sources) if isinstance(source, Path)]
    pool = ThreadPoolExecutor(available_cores())
    try:
        futures = {pool.submit(read, k): k for k in files}
        for future in as_completed(futures):
            k, found = futures[future], future.result()
            if isinstance(found, UrushiError):
                yield k, found
            else:
                material = encode_found(sources[k], found, models[k], refine=refine)
                yield k, (material, found.deviations)
        for k in set(range(len(sources))).difference(files):
            try:
                yield k, encode_source(sources[k], models[k], refine=refine, table=table)
            except UrushiError as error:
                yield k, error
    finally:
        pool.shutdown(cancel_futures=True)
