"""Measures of error of images and of tables of BRDF values, and what sums errors up."""

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.errors import ParameterError

#: Added to the squared reference in the relative error of images, against division by zero.
IMAGE_OFFSET = 1e-2


def summary(errors: npt.ArrayLike) -> dict[str, float]:
    """Mean, median and 95th percentile over all `errors` of any shape."""
    (errors,) = checks.finite(errors=errors)
    if errors.size == 0:
        raise ParameterError("errors is empty; there is nothing to summarise")
    median, high = np.percentile(errors, [50, 95])
    return {"mean": float(errors.mean()), "median": float(median), "p95": float(high)}


def mse(image: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean squared difference over all pixels and channels."""
    image, reference = checks.finite(image=image, reference=reference)
    return float(((image - reference) ** 2).mean())


def relative_mse(
    image: npt.ArrayLike,
    reference: npt.ArrayLike,
    *,
    variance: npt.ArrayLike = 0.0,
    offset: float = IMAGE_OFFSET,
) -> float:
    """Mean of ((image - reference)^2 - variance) / (reference^2 + offset).

    Args:
        image, reference: (H, W, C) linear radiance.
        variance: variance of the noise in these images, by pixel or constant, as
            `halves_variance` gives it. What is left is the error that more samples of the
            reference would not remove; by chance it may fall below zero.
        offset: keeps dark pixels finite, in units of the squared radiance.
    """
    image, reference, variance = checks.finite(image=image, reference=reference, variance=variance)
    return float((((image - reference) ** 2 - variance) / (reference**2 + offset)).mean())


def halves_variance(first: npt.ArrayLike, second: npt.ArrayLike) -> np.ndarray:
    """Estimate by pixel the variance of (first + second) / 2 from two independent renders.

    Unbiased, with one degree of freedom a pixel: Var = (first - second)^2 / 4. Noisy for one
    pixel, good for a mean over many.

    Args:
        first, second: (...) renders of one scene, of equal sample count, with different seeds.
    """
    first, second = checks.finite(first=first, second=second)
    return (first - second) ** 2 / 4


def psnr(image: npt.ArrayLike, reference: npt.ArrayLike, *, peak: float = 1.0) -> float:
    """Peak signal-to-noise ratio [dB], 10 log10(peak^2 / MSE); infinite for equal images."""
    error = mse(image, reference)
    return float("inf") if error == 0 else float(10 * np.log10(peak**2 / error))


def mae(table: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean absolute difference over all entries."""
    table, reference = checks.finite(table=table, reference=reference)
    return float(np.abs(table - reference).mean())


def smape(table: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Symmetric mean absolute percentage error as a fraction: mean of 2 |a - b| / (|a| + |b|).

    From 0 to 2; entries where both are zero count as exact.
    """
    table, reference = checks.finite(table=table, reference=reference)
    total = np.abs(table) + np.abs(reference)
    return float((2 * np.abs(table - reference) / np.where(total > 0, total, 1)).mean())
