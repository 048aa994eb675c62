"""Hashes of rows of numbers, by which the texels of a texture are compared.

Equal texels are computed once, and texels that stay equal after a change are not computed again.
"""

from collections.abc import Sequence

import numpy as np

#: Bits of the mantissa that numbers are rounded to, a relative step of 1e-4: texture filters return
#: texels with rounding errors, and half precision rounds more.
MANTISSA_BITS = 12

#: Constants of splitmix64 (Steele, Lea and Flood 2014).
_GAMMA, _FIRST, _SECOND = (
    np.uint64(x) for x in (0x9E3779B97F4A7C15, 0xBF58476D1CE4E5B9, 0x94D049BB133111EB)
)


def row_hashes(columns: Sequence[np.ndarray], bits: int = MANTISSA_BITS) -> np.ndarray:
    """Hashes uint64 (...) of rows; the columns are arrays that broadcast to (...).

    Columns are floating-point numbers, which are rounded to `bits` of mantissa, or hashes (uint64).
    Two different rows have the same hash with a probability of 2^-64.
    """
    key: np.ndarray = np.zeros((), np.uint64)
    for column in columns:
        if column.dtype != np.uint64:
            column = rounded_bits(column, bits).astype(np.uint64)
        key = _mixed((key ^ column) + _GAMMA)
    return np.ascontiguousarray(key).reshape(key.shape)


def rounded_bits(numbers: np.ndarray, kept: int = MANTISSA_BITS) -> np.ndarray:
    """The bits, uint32, of numbers in single precision, rounded to `kept` bits of mantissa."""
    bits = np.asarray(numbers + np.float32(0), np.float32).view(np.uint32)  # -0 is 0
    dropped = 23 - kept
    return (bits + np.uint32(1 << (dropped - 1))) >> np.uint32(dropped)


def _mixed(x: np.ndarray) -> np.ndarray:
    with np.errstate(over="ignore"):
        x = (x ^ (x >> np.uint64(30))) * _FIRST
        x = (x ^ (x >> np.uint64(27))) * _SECOND
        return x ^ (x >> np.uint64(31))


def unique_rows(keys: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Indices where each distinct key of keys (M,) occurs first, and labels (M,) into these."""
    ordered = np.sort(keys)
    if (ordered[1:] != ordered[:-1]).all():
        return np.arange(len(keys)), np.arange(len(keys))
    order = np.argsort(keys)  # vectorised, unlike the stable one of np.unique
    ordered = keys[order]
    starts = np.flatnonzero(np.append(True, ordered[1:] != ordered[:-1])[: len(keys)])
    first = np.minimum.reduceat(order, starts)
    stands = np.zeros(len(keys), bool)
    stands[first] = True
    rank = np.cumsum(stands) - 1
    label = np.empty_like(order)
    label[order] = np.repeat(rank[first], np.diff(starts, append=len(keys)))
    return np.flatnonzero(stands), label
