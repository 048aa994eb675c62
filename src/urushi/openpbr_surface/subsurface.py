"""The medium that gives a body its subsurface_color, by light transport (3.2.3)."""

import functools

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.material import adding

#: Optical depth of the medium that stands for a half-space, over 1 - g.
DEPTH = 200.0

#: Number of albedos at which colours are computed.
NODES = 25


def subsurface_albedo(color: np.ndarray, g: float, eta: float) -> np.ndarray:
    """The single-scattering albedo of the medium that gives a body its subsurface_color.

    Args:
        color: share of the light along the normal that enters through the interface and leaves it
            again, in [0, 1].
        g: subsurface_scatter_anisotropy.
        eta: index of the body relative to the medium outside.

    Source: the specification inverts van de Hulst's albedo of a half-space without an interface.
    """
    s, colors = _colors(float(g), float(eta))
    s2 = np.interp(color, colors, s) ** 2
    return (1 - s2) / (1 - g * s2)


@functools.lru_cache(maxsize=16)
def _colors(g: float, eta: float) -> tuple[np.ndarray, np.ndarray]:
    """Van de Hulst's similarity parameters (N,), of which colours (N,) are nearly linear."""
    s = np.linspace(1, 0, NODES)
    back, weights = adding.interface_modes(MIN_ALPHA, eta)[0], adding.grid().weights
    passed = weights * (1 - back @ weights)
    colors = [0.0]
    for x in s[1:-1] ** 2:
        albedo = (1 - x) / (1 - g * x)
        below = adding.medium(*adding.resolved(albedo, DEPTH / (1 - g), g))[0][0]
        trapped = (below * weights) @ (back * weights)
        colors.append(np.linalg.solve(np.eye(len(weights)) - trapped, below)[0] @ passed)
    return s, np.array([*colors, 1.0])
