"""Error measures of images, and pictures as a display shows them."""

import numpy as np
import numpy.typing as npt

from urushi import checks


def mse(image: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean squared difference over all pixels and channels."""
    image, reference = checks.finite(image=image, reference=reference)
    return float(((image - reference) ** 2).mean())


def relative_mse(
    image: npt.ArrayLike,
    reference: npt.ArrayLike,
    *,
    variance: npt.ArrayLike = 0.0,
    offset: float = 1e-2,
) -> float:
    """Mean of ((image - reference)^2 - variance) / (reference^2 + offset).

    Args:
        image, reference: (H, W, C) linear radiance.
        variance: variance of the noise in these images, by pixel or constant, as
            `halves_variance` gives it. The rest is the error that more samples would not remove;
            by chance it may be below zero.
        offset: keeps dark pixels finite, in units of the squared radiance.
    """
    image, reference, variance = checks.finite(image=image, reference=reference, variance=variance)
    return float((((image - reference) ** 2 - variance) / (reference**2 + offset)).mean())


def halves_variance(first: npt.ArrayLike, second: npt.ArrayLike) -> np.ndarray:
    """Estimate by pixel the variance of (first + second) / 2 from two independent renders.

    These have equal sample counts and different seeds. Unbiased, with one degree of freedom per
    pixel: Var = (first - second)^2 / 4. It is noisy in one pixel and accurate in the mean of many.
    """
    first, second = checks.finite(first=first, second=second)
    return (first - second) ** 2 / 4


def psnr(image: npt.ArrayLike, reference: npt.ArrayLike, *, peak: float = 1.0) -> float:
    """Peak signal-to-noise ratio [dB], 10 log10(peak^2 / MSE); infinite for equal images."""
    error = mse(image, reference)
    return float("inf") if error == 0 else float(10 * np.log10(peak**2 / error))


def srgb(linear: np.ndarray) -> np.ndarray:
    """The transfer function of IEC 61966-2-1, for values in [0, 1]."""
    power = 1.055 * np.maximum(linear, 0.0031308) ** (1 / 2.4) - 0.055
    return np.where(linear <= 0.0031308, 12.92 * linear, power)


def shown(radiance: npt.ArrayLike) -> np.ndarray:
    """sRGB values in [0, 1] of linear radiance (H, W, 3), clipped at 1."""
    (radiance,) = checks.finite(radiance=radiance)
    return srgb(np.clip(radiance, 0, 1))
