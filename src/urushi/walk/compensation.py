"""The option `energy_compensation` of coats: light that a rough surface loses is given back.

A surface scatters light once. Light that meets a second facet is lost. L(w) is the share that the
topmost surface loses over a white base (`core.albedos.surface_loss`). The lobe
C L(wi) L(wo) / (pi L_mean) gives it back (Kulla and Conty 2017). C is the colour of coat and
bottom. A mirror loses less than a Lambertian base: its light leaves the coat as steeply as it
entered.
The plugins have the same lobe (`mitsuba.plugins.estimates`).
"""

import numpy as np

from urushi.checks import CoatParameters, Widths
from urushi.core import albedos
from urushi.core.appearance import coated_color
from urushi.core.namespace import NUMPY
from urushi.walk.stack import Stack


class Compensation:
    """The lobe of a stack's topmost coat.

    below: (3,) directional albedo, at the normal, of what lies under the coat.
    mirrored: the share of this light that is mirrored.
    """

    def __init__(self, stack: Stack, below: np.ndarray, mirrored: float):
        top = stack.coats[0]
        alpha, eta = top.alpha, np.broadcast_to(top.eta, 3)
        if isinstance(alpha, Widths):
            alpha = np.sqrt(0.5 * (np.square(alpha.u) + np.square(alpha.v)))
        medium = (np.asarray(x) for x in (top.albedo, top.sigma_t, top.g))
        self._color = coated_color(CoatParameters(alpha, eta, *medium), below, NUMPY)
        self._losses = [
            albedos.surface_loss(float(a), float(e), mirrored)
            for a, e in zip(np.broadcast_to(alpha, 3), eta, strict=True)
        ]

    def albedo(self, cosine: np.ndarray) -> np.ndarray:
        """What the lobe adds to the directional albedo at cosines (N,), (N, 3)."""
        return self._color * np.stack([lost(cosine) for lost, _ in self._losses], axis=-1)

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The lobe [1/sr] (N, 3) for unit vectors (N, 3); 0 below the horizon."""
        lobes = [
            lost(wi[:, 2]) * lost(wo[:, 2]) / max(np.pi * mean, 1e-5) for lost, mean in self._losses
        ]
        above = (wi[:, 2:] > 0) & (wo[:, 2:] > 0)
        return np.where(above, self._color * np.stack(lobes, axis=-1), 0)
