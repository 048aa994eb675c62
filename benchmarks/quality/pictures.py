"""Differences of pictures as a display shows them: PSNR, SSIM and FLIP."""

from dataclasses import asdict, dataclass, fields

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core.error_metrics import mse, psnr, shown
from urushi.errors import ParameterError, PlatformError
from urushi.platform import install_command

#: PSNR of equal pictures [dB], finite so that means are finite. It is higher than that of any two
#: different pictures of 16 bits per channel.
BEST_PSNR = 100.0


@dataclass(frozen=True)
class Comparison:
    """Differences of two pictures in sRGB values in [0, 1].

    Attributes:
        mae, rmse: mean absolute and root mean squared difference.
        psnr: peak signal-to-noise ratio [dB], at most `BEST_PSNR`.
        ssim: structural similarity (Wang et al. 2004), 1 for equal pictures.
        flip: mean of FLIP (Andersson et al. 2020), 0 for equal pictures; NaN: not computed.
    """

    mae: float
    rmse: float
    psnr: float
    ssim: float
    flip: float = np.nan

    @classmethod
    def mean(cls, several: "list[Comparison]") -> "Comparison":
        """The mean of every measure over several comparisons."""
        return cls(*(float(np.mean([getattr(c, f.name) for c in several])) for f in fields(cls)))

    def as_dict(self) -> dict[str, float]:
        return asdict(self)


def mae(table: npt.ArrayLike, reference: npt.ArrayLike) -> float:
    """Mean absolute difference over all entries."""
    table, reference = checks.finite(table=table, reference=reference)
    return float(np.abs(table - reference).mean())


def compare(
    image: npt.ArrayLike,
    reference: npt.ArrayLike,
    mask: npt.ArrayLike | None = None,
    *,
    flip: bool = True,
) -> Comparison:
    """Compare two pictures in sRGB values.

    Args:
        image, reference: (H, W, 3) linear radiance, at least 11 pixels high and wide.
        mask: bool (H, W), the pixels to compare; default: all. A black background would make
            every measure better.
        flip: whether to compute FLIP, which needs the package flip-evaluator.

    Raises:
        ParameterError: shapes differ, a number is not finite, or the mask is empty.
        PlatformError: a package is missing.
    """
    image, reference = shown(image), shown(reference)
    _check_shapes(image, reference)
    inside = np.ones(image.shape[:2], bool) if mask is None else np.asarray(mask, bool)
    if inside.shape != image.shape[:2] or not inside.any():
        raise ParameterError(
            f"the mask has shape {inside.shape} and {inside.sum()} pixels of an image of "
            f"{image.shape[:2]}; give one of the image's shape that is not empty"
        )
    pixels, expected = image[inside], reference[inside]
    return Comparison(
        mae=mae(pixels, expected),
        rmse=float(np.sqrt(mse(pixels, expected))),
        psnr=min(psnr(pixels, expected), BEST_PSNR),
        ssim=float(ssim_map(image, reference)[inside].mean()),
        flip=float(flip_map(image, reference)[inside].mean()) if flip else np.nan,
    )


def ssim_map(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Structural similarity by pixel (H, W), averaged over channels, of values in [0, 1].

    Gaussian window and constants of Wang et al. 2004.
    """
    try:
        from skimage.metrics import structural_similarity  # lazily: an extra
    except ImportError as error:
        raise PlatformError(
            f"SSIM needs the package scikit-image; install it: {install_command('eval')}"
        ) from error
    _, result = structural_similarity(
        reference,
        image,
        data_range=1.0,
        channel_axis=2,
        gaussian_weights=True,
        sigma=1.5,
        use_sample_covariance=False,
        full=True,
    )
    return result.mean(axis=2)


def flip_map(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """FLIP by pixel (H, W) of pictures in [0, 1], at 67 pixels per degree of the visual field."""
    try:
        import flip_evaluator  # lazily: it has no wheels for some platforms
    except ImportError as error:
        raise PlatformError(
            "FLIP needs the package flip-evaluator; install it with: pip install flip-evaluator"
        ) from error
    pair = (np.ascontiguousarray(x, dtype=np.float32) for x in (reference, image))
    result, _, _ = flip_evaluator.evaluate(*pair, "LDR", applyMagma=False)
    return result.reshape(image.shape[:2])


def _check_shapes(image: np.ndarray, reference: np.ndarray) -> None:
    if image.shape != reference.shape or image.ndim != 3 or image.shape[2] != 3:
        raise ParameterError(
            f"the pictures have shapes {image.shape} and {reference.shape}; give two (H, W, 3)"
        )
    if min(image.shape[:2]) < 11:
        raise ParameterError(
            f"the pictures have {image.shape[:2]} pixels; SSIM needs 11 in each direction"
        )
