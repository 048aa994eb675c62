"""Published models of layered materials, beside which the networks are measured."""

from collections.abc import Callable, Sequence

import numpy as np

from urushi.walk.monte_carlo import per_channel
from urushi.walk.stack import Stack


def values_per_channel(
    stack: Stack, directions: Sequence[np.ndarray], rows: Callable[..., np.ndarray]
) -> np.ndarray:
    """Evaluate a closed form for every channel of a stack: (N, 3).

    stack, directions: as of `per_channel`. rows: rows(table, row, *directions) -> (M,).
    """
    return per_channel(stack, directions, lambda *given: (rows(*given),))[0]
