"""Measures of error: E and P of a stack's BRDF values, and those of images."""

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError

#: Cosines below this count as this, so that single grazing pairs carry no less than any other.
COSINE_FLOOR = 0.02

#: [1/sr] Added to the reference in P: differences far below it are invisible.
P_OFFSET = 1e-3

#: Added to the squared reference in the relative error of images, against division by zero.
IMAGE_OFFSET = 1e-2


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
        (...) float64: 0 is exact, 1 means an error as large as the reflected energy itself.

    Raises:
        ParameterError: a value is not finite, a shape does not fit, or a reference is black.
    """
    f_hat, f, cos_i, cos_o = _finite(f_hat=f_hat, f=f, cos_i=cos_i, cos_o=cos_o)
    weight = np.maximum(cos_i, COSINE_FLOOR) * np.maximum(cos_o, COSINE_FLOOR)
    energy = (f * weight).sum(-1)
    if (energy <= 0).any():
        raise ParameterError(
            "f reflects no energy in at least one stack, where E is undefined; leave that stack out"
        )
    return (np.abs(f_hat - f) * weight).sum(-1) / energy


def pair_error(f_hat: npt.ArrayLike, f: npt.ArrayLike) -> np.ndarray:
    """P = |f_hat - f| / (f + 0.001): the relative error of every pair, lobe peak or tail alike.

    Args:
        f_hat, f: (...) values to judge and reference values [1/sr], at pairs whose tangent of the
            half angle is log-uniform in [0.001, 4].

    Returns:
        (...) float64.
    """
    f_hat, f = _finite(f_hat=f_hat, f=f)
    return np.abs(f_hat - f) / (f + P_OFFSET)


def summary(errors: npt.ArrayLike) -> dict[str, float]:
    """Mean, median and 95th percentile over all `errors` of any shape."""
    (errors,) = _finite(errors=errors)
    if errors.size == 0:
        raise ParameterError("errors is empty; there is nothing to summarise")
    median, high = np.percentile(errors, [50, 95])
    return {"mean": float(errors.mean()), "median": float(median), "p95": float(high)}


def mse(image: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean squared difference over all pixels and channels."""
    image, reference = _finite(image=image, reference=reference)
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
    image, reference, variance = _finite(image=image, reference=reference, variance=variance)
    return float((((image - reference) ** 2 - variance) / (reference**2 + offset)).mean())


def halves_variance(first: npt.ArrayLike, second: npt.ArrayLike) -> np.ndarray:
    """Estimate by pixel the variance of (first + second) / 2 from two independent renders.

    Unbiased, with one degree of freedom a pixel: Var = (first - second)^2 / 4. Noisy for one
    pixel, good for a mean over many.

    Args:
        first, second: (...) renders of one scene, of equal sample count, with different seeds.
    """
    first, second = _finite(first=first, second=second)
    return (first - second) ** 2 / 4


def psnr(image: npt.ArrayLike, reference: npt.ArrayLike, *, peak: float = 1.0) -> float:
    """Peak signal-to-noise ratio [dB], 10 log10(peak^2 / MSE); infinite for equal images."""
    error = mse(image, reference)
    return float("inf") if error == 0 else float(10 * np.log10(peak**2 / error))


def _finite(**arrays: npt.ArrayLike) -> list[np.ndarray]:
    """Float64 arrays, checked to be finite and to broadcast; errors name the argument."""
    result = {name: np.asarray(value, dtype=np.float64) for name, value in arrays.items()}
    for name, array in result.items():
        if not np.isfinite(array).all():
            raise ParameterError(f"{name} holds NaN or infinity; every value must be finite")
    try:
        np.broadcast_shapes(*(array.shape for array in result.values()))
    except ValueError as error:
        shapes = ", ".join(f"{name} {array.shape}" for name, array in result.items())
        raise ParameterError(f"shapes do not fit together: {shapes}") from error
    return list(result.values())
