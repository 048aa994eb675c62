"""Lobes by which a proposal represents what lies below coats."""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.recording import opaque

#: Samples from which a bottom's lobes are estimated.
SAMPLES = 1 << 14
#: Ratio of a bottom lobe's two widths from which its lobe in a proposal has both. The estimate of
#: the ratio has a standard error of about 2 %.
ANISOTROPIC_RATIO = 1.25


class BottomLobes:
    """Two GGX lobes and the directional albedo of a BSDF at normal incidence, by sampling it.

    For a GGX reflector and wi at the normal, the share q of samples with tan theta_h below t is
    q = t^2 / (alpha^2 + t^2), so that alpha follows from any quantile. The first and the third
    quartile of another BSDF give a narrow and a wide lobe. Along one axis, the share with
    |h.x / h.z| below t is q = t / sqrt(alpha_u^2 + t^2), from which follow the widths of an
    anisotropic lobe.
    """

    def __init__(self, bsdf: "mi.BSDF"):
        rng = mi.PCG32(size=SAMPLES)
        uv = np.random.default_rng(0).random((SAMPLES, 2), np.float32)
        si = probing.interaction(np.tile([0.0, 0.0, 1.0], (SAMPLES, 1)), uv)
        u = mi.Point2f(rng.next_float32(), rng.next_float32())
        bs, weight = bsdf.sample(mi.BSDFContext(), si, rng.next_float32(), u)
        valid = (bs.pdf > 0) & (bs.wo.z > 0)
        half = bs.wo + mi.Vector3f(0, 0, 1)
        tangent = (dr.hypot(half.x, half.y) / half.z).numpy()
        share = np.where(valid.numpy(), spectrum.mean(spectrum.as_color(weight)).numpy(), 0)
        below = _cumulative(tangent, share)[1]
        self.albedo = opaque(min(below[-1] / SAMPLES, 1))
        self._alphas = []  # of each lobe, one width or two
        for q in (0.25, 0.75):
            along_axis = (1 - q * q) ** 0.5 / q
            widths = [
                width(np.abs(slope.numpy()), share, q, along_axis)
                for slope in (half.x / half.z, half.y / half.z)
            ]
            if max(widths) < ANISOTROPIC_RATIO * min(widths):
                widths = [width(tangent, share, q, ((1 - q) / q) ** 0.5)]
            self._alphas.append([opaque(width) for width in widths])

    @property
    def alphas(self) -> list[Any]:
        """The widths of the two lobes, `Widths` of those that are anisotropic."""
        return [alpha[0] if len(alpha) == 1 else Widths(*alpha) for alpha in self._alphas]


def _cumulative(tangent: np.ndarray, share: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Tangents in ascending order, and the sums of the weights up to each."""
    order = np.argsort(tangent)
    return tangent[order], np.cumsum(share[order])


def width(tangent: np.ndarray, share: np.ndarray, q: float, factor: float) -> float:
    """A GGX width: a factor times the q-quantile of tangents of the given weights."""
    ascending, below = _cumulative(tangent, share)
    if below[-1] == 0:
        return 0.5  # black: the width does not matter
    return float(ascending[np.searchsorted(below, q * below[-1])] * factor)
