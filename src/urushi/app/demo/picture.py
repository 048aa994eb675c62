"""Pictures for looking at: tone curve, difference in false colour, panels side by side."""

import os

import mitsuba as mi
import numpy as np

from urushi.eval.image_metrics import srgb
from urushi.files import atomic_write

#: Relative differences of this size and more are shown in full colour.
DIFFERENCE_SCALE = 0.25


def tonemap(radiance: np.ndarray) -> np.ndarray:
    """Film-like curve (the fit of Narkowicz 2015 to ACES), then the sRGB transfer function.

    Args:
        radiance: (H, W, 3) linear, 1 a bright surface; highlights above roll off softly.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    x = np.maximum(radiance, 0)
    curve = x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
    return srgb(np.clip(curve, 0, 1))


def difference(image: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """Signed relative difference of luminance: black where equal, orange too bright, blue too dark.

    Args:
        image, reference: (H, W, 3) linear radiance.

    Returns:
        (H, W, 3) display values in [0, 1].
    """
    weights = np.array([0.2126, 0.7152, 0.0722])  # of Rec. 709
    luminance = reference @ weights
    relative = (image @ weights - luminance) / (luminance + 0.05)
    amount = np.clip(np.abs(relative) / DIFFERENCE_SCALE, 0, 1)[..., None]
    colour = np.where(relative[..., None] > 0, [1.0, 0.55, 0.15], [0.2, 0.55, 1.0])
    return amount * colour


def side_by_side(*panels: np.ndarray, gap: int = 4) -> np.ndarray:
    """Join (H, W, 3) display images from left to right, with white gaps."""
    white = np.ones((panels[0].shape[0], gap, 3))
    joined = [part for panel in panels for part in (white, panel)][1:]
    return np.concatenate(joined, axis=1)


def write_png(image: np.ndarray, path: str | os.PathLike) -> None:
    """Write (H, W, 3) display values in [0, 1] as an 8-bit PNG, whole or not at all."""
    pixels = np.round(255 * np.clip(image, 0, 1)).astype(np.uint8)
    with atomic_write(path) as temporary:
        mi.Bitmap(np.ascontiguousarray(pixels)).write(str(temporary))


def write_exr(image: np.ndarray, path: str | os.PathLike) -> None:
    """Write (H, W, 3) linear radiance as a float32 EXR, whole or not at all."""
    with atomic_write(path) as temporary:
        mi.Bitmap(np.ascontiguousarray(image, dtype=np.float32)).write(str(temporary))
