"""Evaluating networks on many rows in bounded memory."""

from collections.abc import Callable

import numpy as np

#: Rows at once: some tens of MB of activations, and matrices large enough for full speed.
ROWS = 1 << 15


def in_chunks(
    function: Callable[..., np.ndarray], *arrays: np.ndarray, rows: int = ROWS
) -> np.ndarray:
    """Return function(*arrays) for arrays of equal first dimension, `rows` of them at a time.

    The result's shape and type are those of the first chunk; no rows at all are one empty chunk.
    """
    count = len(arrays[0])
    if count <= rows:
        return function(*arrays)
    parts = (
        function(*(array[start : start + rows] for array in arrays))
        for start in range(0, count, rows)
    )
    first = next(parts)
    result = np.empty((count, *first.shape[1:]), first.dtype)
    result[: len(first)] = first
    start = len(first)
    for part in parts:
        result[start : start + len(part)] = part
        start += len(part)
    return result
