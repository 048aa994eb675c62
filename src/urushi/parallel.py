"""Filling large arrays by all cores, block by block, in bounded memory."""

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

#: Rows at once on each core: their activations about fill its own cache, and the matrices are
#: large enough for full speed.
ROWS = 1 << 10

Block = tuple[slice, ...]

#: BLAS is held to one thread for the whole process, and only who found it free may free it.
_turn = threading.Lock()


def fill_blocks(
    out: np.ndarray,
    function: Callable[..., np.ndarray],
    *arrays: np.ndarray,
    rows: int | None = None,
) -> None:
    """Write function(*arrays) to out (..., K), one block of its leading dimensions at a time.

    Args:
        out: the result.
        function: of blocks of the arrays; returns (..., K). It must not call `fill`.
        arrays: as many first dimensions as out's leading ones, to which they broadcast. Blocks
            broadcast in the same manner, a dimension of one being left as it is, so that what
            rows share is worked out once a block.
        rows: entries of the leading dimensions in a block, at most; by default as suits networks.

    An error or the user's interrupt drops the blocks that are not yet begun, and leaves `out`
    unfinished.
    """
    pieces = blocks(out.shape[:-1], rows or ROWS)

    def task(block: Block) -> None:
        out[block] = function(*(_part(array, block) for array in arrays))

    if len(pieces) > 1:
        run_all_cores(task, pieces)
    else:
        for block in pieces:
            task(block)


def blocks(shape: tuple[int, ...], rows: int) -> list[Block]:
    """Cut an array of a shape into blocks of at most `rows` entries, as even as its axes allow."""
    axis, inner = len(shape), 1  # the axes from this one on fit into a block together
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


def _part(array: np.ndarray, block: Block) -> np.ndarray:
    """The part of an array that broadcasts to a block."""
    sizes = array.shape[: len(block)]
    return array[tuple(slice(None) if n == 1 else cut for n, cut in zip(sizes, block, strict=True))]


def run_all_cores(task: Callable[[Any], None], pieces: Sequence[Any]) -> None:
    """Call the task with every piece, on all cores; one call of this at a time has them.

    The task must call neither this nor `fill`.
    """
    alone = functools.partial(_blas().limit, limits=1)
    with _turn, alone():  # threads of BLAS and ours would wait for each other
        # Some builds of BLAS count each thread's own threads: hence the initializer.
        pool = ThreadPoolExecutor(available_cores(), "urushi", initializer=alone)
        try:
            for future in [pool.submit(task, piece) for piece in pieces]:
                future.result()
        finally:
            pool.shutdown(cancel_futures=True)


@contextlib.contextmanager
def one_blas_thread() -> Iterator[None]:
    """Hold BLAS to one thread: where matrices are small, several only wait for each other.

    Not within a function that `fill` calls.
    """
    with _turn, _blas().limit(limits=1):
        yield


@functools.cache
def _blas() -> ThreadpoolController:
    return ThreadpoolController().select(user_api="blas")
