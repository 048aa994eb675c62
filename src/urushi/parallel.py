"""Parallel evaluation of large arrays on all cores, block by block, in bounded memory."""

import contextlib
import functools
import itertools
import math
import threading
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
from threadpoolctl import ThreadpoolController

from urushi.platform import available_cores

#: Default number of rows per block. The activations of a block about fill a core's cache, and its
#: matrices are large enough for full speed.
ROWS = 1 << 10

Block = tuple[slice, ...]

#: Held while BLAS is limited to one thread, a limit that applies to the whole process.
_blas_lock = threading.Lock()

#: `at_work` is true in threads of `run_all_cores`, and within `one_blas_thread`.
_thread = threading.local()


def fill_blocks(
    out: np.ndarray,
    function: Callable[..., np.ndarray],
    *arrays: np.ndarray,
    rows: int | None = None,
) -> np.ndarray:
    """Write function(*arrays) to out (..., K), one block of the leading dimensions at a time.

    Returns `out`.

    Args:
        out: the result.
        function: maps blocks of the arrays to (..., K).
        arrays: arrays whose first dimensions broadcast to the leading dimensions of `out`. Blocks
            keep dimensions of size one, so that the function computes shared values once per
            block.
        rows: largest number of entries of the leading dimensions in a block; `ROWS` by default.

    After an error or an interrupt by the user, blocks that have not begun are dropped and `out`
    is incomplete.
    """
    if math.prod(out.shape[:-1]) <= (rows or ROWS):
        out[...] = function(*arrays)
        return out

    def task(block: Block) -> None:
        parts = []
        for array in arrays:  # dimensions of size one are kept
            sizes = zip(array.shape[: len(block)], block, strict=True)
            parts.append(array[tuple(slice(None) if n == 1 else cut for n, cut in sizes)])
        out[block] = function(*parts)

    run_all_cores(task, blocks(out.shape[:-1], rows or ROWS))
    return out


def blocks(shape: tuple[int, ...], rows: int) -> list[Block]:
    """Divide an array of a shape into blocks of at most `rows` entries, of about equal size."""
    axis, inner = len(shape), 1  # the axes from this one on fit into one block
    while axis and inner * shape[axis - 1] <= rows:
        axis -= 1
        inner *= shape[axis]
    whole = (slice(None),) * (len(shape) - axis)
    if not axis:
        return [whole]
    size = shape[axis - 1]
    count = math.ceil(size / (rows // inner))
    edges = [size * i // count for i in range(count + 1)]
    cuts = [slice(start, stop) for start, stop in itertools.pairwise(edges)]
    outer = np.ndindex(*shape[: axis - 1])
    return [(*(slice(i, i + 1) for i in index), cut, *whole) for index in outer for cut in cuts]


def run_all_cores(task: Callable[[Any], None], pieces: Sequence[Any]) -> None:
    """Call the task for every piece, on all cores. Concurrent calls wait for each other.

    Within a task or `one_blas_thread`, the pieces of a further call are done one after another.
    """
    if _at_work():
        for piece in pieces:
            task(piece)
        return

    def begin() -> None:
        _thread.at_work = True
        _blas().limit(limits=1)  # some builds of BLAS limit each calling thread separately

    with one_blas_thread():  # threads of BLAS would compete with the pool's
        pool = ThreadPoolExecutor(available_cores(), "urushi", initializer=begin)
        try:
            for future in [pool.submit(task, piece) for piece in pieces]:
                future.result()
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Limit BLAS to one thread, which is faster for small matrices.

    Within this context, and within a task of `run_all_cores`, it does nothing.
    """
    if _at_work():
        yield
        return
    with _blas_lock, _blas().limit(limits=1):
        _thread.at_work = True
        try:
            yield
        finally:
            _thread.at_work = False


def _at_work() -> bool:
    """Whether this thread already works with one thread of BLAS."""
    return getattr(_thread, "at_work", False)


@functools.cache
def _blas() -> ThreadpoolController:
    """The BLAS libraries of this process."""
    return ThreadpoolController().select(user_api="blas")
