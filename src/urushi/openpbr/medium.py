"""The medium of the coat."""

from typing import Any

import numpy as np

#: Least coat_color: its optical depth is 6.9, from which nothing returns.
LEAST_COLOR = 1e-6


def optical_depth(coat_color: Any, xp: Any = np) -> Any:
    """The optical depth of the coat, which absorbs and does not scatter.

    coat_color is the square of the transmittance at normal incidence, exp(-2 sigma_t).

    Args:
        coat_color: in [0, 1]; values below `LEAST_COLOR` count as that.
        xp: the module of the arrays' functions, NumPy or drjit.

    Returns:
        sigma_t, zero or more, of the same shape; 0.0 where the colour is one.

    Source: OpenPBR 1.1.1, Coat.
    """
    return xp.abs(0.5 * xp.log(xp.clip(coat_color, LEAST_COLOR, 1)))
