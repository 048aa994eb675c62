"""Errors of images, and the weights of pairs in errors of BRDFs."""

import numpy as np
import numpy.typing as npt

from urushi import checks

#: Least cosine in the weights of E, so that grazing pairs are not ignored.
COSINE_FLOOR = 0.02

#: Added to squared radiances in relative errors of images, which keeps dark pixels finite.
DARK_SQUARE = 1e-2


def energy_weight(cos_i: npt.ArrayLike, cos_o: npt.ArrayLike) -> np.ndarray:
    """The weight of a pair in E: the product of its cosines (...), clamped to `COSINE_FLOOR`."""
    return np.maximum(cos_i, COSINE_FLOOR) * np.maximum(cos_o, COSINE_FLOOR)


def mse(image: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean squared difference over all pixels and channels."""
    image, reference = checks.finite(image=image, reference=reference)
    return float(((image - reference) ** 2).mean())


def relative_mse(
    image: npt.ArrayLike, reference: npt.ArrayLike, *, variance: npt.ArrayLike = 0.0
) -> float:
    """Mean of ((image - reference)^2 - variance) / (reference^2 + `DARK_SQUARE`).

    Args:
        image, reference: (H, W, C) linear radiance.
        variance: variance of the noise in these images, by pixel or constant, as
            `halves_variance` gives it. The rest is the error that more samples would not remove;
            by chance it may be below zero.
    """
    image, reference, variance = checks.finite(image=image, reference=reference, variance=variance)
    error = (image - reference) ** 2 - variance
    return float((error / (reference**2 + DARK_SQUARE)).mean())


def halves_variance(first: npt.ArrayLike, second: npt.ArrayLike) -> np.ndarray:
    """Estimate by pixel the variance of (first + second) / 2 from two independent renders.

    These have equal sample counts and different seeds. Unbiased, with one degree of freedom per
    pixel: Var = (first - second)^2 / 4. It is noisy in one pixel and accurate in the mean of many.
    """
    first, second = checks.finite(first=first, second=second)
    return (first - second) ** 2 / 4


def psnr(image: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Signal-to-noise ratio [dB] to a peak of 1, 10 log10(1 / MSE); infinite for equal images."""
    error = mse(image, reference)
    return float("inf") if error == 0 else float(10 * np.log10(1 / error))


def srgb(linear: np.ndarray) -> np.ndarray:
    """The transfer function of IEC 61966-2-1, for values in [0, 1]."""
    power = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, power)


def shown(radiance: npt.ArrayLike) -> np.ndarray:
    """sRGB values in [0, 1] of linear radiance (H, W, 3), clipped at 1."""
    (radiance,) = checks.finite(radiance=radiance)
    return srgb(np.clip(radiance, 0, 1))
