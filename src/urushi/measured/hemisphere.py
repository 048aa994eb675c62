"""What every measured BRDF does with its directions before it looks anything up."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from urushi import checks

#: Numbers looked up at once: bounds the memory of a call, whatever the number of pairs.
CHUNK = 1 << 19

_LARGEST = float(np.finfo(np.float32).max)


def evaluate(
    lookup: Callable[[np.ndarray, np.ndarray], np.ndarray],
    channels: int,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike,
    *,
    width: int = 3,
) -> np.ndarray:
    """Evaluate pairs in the upper hemisphere, a chunk at a time; zero where one is not above it.

    Args:
        lookup: maps exact unit vectors wi, wo, float64 (M, 3), to finite values (M, channels).
        channels: how many values `lookup` gives for a pair.
        wi, wo: (N, 3) unit vectors.
        width: how many numbers `lookup` handles for a pair on its way.

    Returns:
        float32 (N, channels).

    Raises:
        ParameterError: wrong shapes, or directions that are not unit vectors.
    """
    wi, wo = checks.directions(wi, wo)
    result = np.zeros((len(wi), channels), np.float32)
    above = np.flatnonzero((wi[:, 2] > 0) & (wo[:, 2] > 0))
    step = max(1, CHUNK // width)
    for start in range(0, len(above), step):
        rows = above[start : start + step]
        values = lookup(_unit(wi[rows]), _unit(wo[rows]))
        result[rows] = np.clip(values, -_LARGEST, _LARGEST)
    return result


def _unit(w: np.ndarray) -> np.ndarray:
    w = w.astype(np.float64)
    return w / np.linalg.norm(w, axis=1, keepdims=True)
