"""What tests of plugins share: textures of given texels, vectors, and f of a BSDF."""

import mitsuba as mi
import numpy as np

from urushi.mitsuba.reading import probing


def bitmap(pixels: np.ndarray, **properties) -> dict:
    """A texture of texels (H, W, C), of numbers as they are."""
    texels = mi.Bitmap(np.asarray(pixels, np.float32))
    return {"type": "bitmap", "bitmap": texels, "raw": True, **properties}


def vector(w: np.ndarray) -> "mi.Vector3f":
    """Vectors (N, 3)."""
    return mi.Vector3f(np.ascontiguousarray(w.T))


def f(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f (N, 3) [1/sr] for pairs (N, 3) above the horizon, at the origin of uv."""
    return probing.bsdf_values(bsdf, wi, wo, np.zeros((len(wi), 2)))
