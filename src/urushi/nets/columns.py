"""Features of networks: columns that become the last axis of one array, in units of their spread.

Functions take arrays of NumPy or JAX.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np


def stacked(columns: Sequence[Any]) -> Any:
    """Columns (...), which broadcast against each other, as an array (..., C)."""
    xp = columns[0].__array_namespace__()
    if xp is not np:
        return xp.stack(xp.broadcast_arrays(*columns), axis=-1)
    # For a few rows, the calls of `np.stack` would take longer than all that they stack.
    shape = np.broadcast(*columns).shape
    result = np.empty((*shape, len(columns)), np.result_type(*columns))
    for place, column in enumerate(columns):
        result[..., place] = column
    return result


class Normalisation:
    """Means and scales of features, by which they have about mean 0 and variance 1."""

    def __init__(self, means: Sequence[float], scales: Sequence[float]):
        """means, scales: one of each for every column."""
        self._means, self._factors = np.array(means), 1.0 / np.array(scales)
        self._of_type: dict[Any, tuple[np.ndarray, np.ndarray]] = {}

    def __call__(self, columns: Sequence[Any]) -> Any:
        """Normalised features (..., C) of columns (...), which broadcast against each other."""
        features = stacked(columns)
        means, factors = self._constants(features.real.dtype)
        features -= means  # in place where arrays can be changed
        features *= factors
        return features

    def each(self, columns: Sequence[Any]) -> list[Any]:
        """The same of columns of any kind, as a list."""
        constants = zip(columns, self._means.tolist(), self._factors.tolist(), strict=True)
        return [(column - mean) * factor for column, mean, factor in constants]

    def _constants(self, dtype: Any) -> tuple[np.ndarray, np.ndarray]:
        """The means and factors (C,) in the precision of the columns."""
        if dtype not in self._of_type:
            self._of_type[dtype] = self._means.astype(dtype), self._factors.astype(dtype)
        return self._of_type[dtype]
