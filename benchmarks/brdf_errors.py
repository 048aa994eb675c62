"""Errors E and P of BRDFs, at cosine pairs and at the pairs of `benchmarks.pairs`."""

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core import error_metrics
from urushi.errors import ParameterError

#: [1/sr] Added to f in P and before logarithms are compared: values far below it look black, and
#: measured colours outside of sRGB have channels that are zero.
DARK_OFFSET = 1e-3


def stack_error(
    f_hat: npt.ArrayLike, f: npt.ArrayLike, cos_i: npt.ArrayLike, cos_o: npt.ArrayLike
) -> np.ndarray:
    """E = sum |f_hat - f| cos_i cos_o / sum f cos_i cos_o: the error of the reflected energy.

    Args:
        f_hat: (..., M) values to judge [1/sr], without cosine, at M pairs of directions drawn
            with cosine density on both sides.
        f: (..., M) reference values [1/sr]; no row may be zero throughout.
        cos_i, cos_o: (..., M) cosines of the pairs to the normal; clamped to `COSINE_FLOOR`.

    Returns:
        (...) float64: 0 for exact values, 1 for an error as large as the reflected energy.

    Raises:
        ParameterError: a value is not finite, a shape does not fit, or a reference is black.
    """
    f_hat, f, cos_i, cos_o = checks.finite(f_hat=f_hat, f=f, cos_i=cos_i, cos_o=cos_o)
    weight = error_metrics.energy_weight(cos_i, cos_o)
    energy = (f * weight).sum(-1)
    if (energy <= 0).any():
        raise ParameterError(
            "f reflects no energy in at least one stack, where E is undefined; leave that stack out"
        )
    return (np.abs(f_hat - f) * weight).sum(-1) / energy


def pair_error(f_hat: npt.ArrayLike, f: npt.ArrayLike) -> np.ndarray:
    """P = |f_hat - f| / (f + 0.001): the relative error of a pair in peaks and tails.

    Args:
        f_hat, f: (...) values to judge and reference values [1/sr], at pairs whose tangent of the
            half angle is log-uniform in [0.001, 4].

    Returns:
        (...) float64.
    """
    f_hat, f = checks.finite(f_hat=f_hat, f=f)
    return np.abs(f_hat - f) / (f + DARK_OFFSET)
