"""Directional albedos of GGX reflectors of two widths, tabulated.

They depend on the azimuth: on a brushed surface, more light hits a second facet across the
scratches than along them.
"""

import functools
from typing import Any, NamedTuple

import numpy as np

from urushi.openpbr import albedo_axes, interface_albedo

#: Nodes of the anisotropy (u - v) / (u + v) of the widths u >= v, and its greatest.
ANISOTROPIES, MOST = 8, 0.98

#: Terms of the cosine series in the azimuth, of 0, 2, 4 and 6 times it.
TERMS = 4

#: Azimuths from which the series is fitted.
_AZIMUTHS = np.linspace(0, np.pi / 2, 7)


class Tables(NamedTuple):
    """Albedos of a reflector whose facets reflect all light, float32.

    Attributes:
        albedo: (ANISOTROPIES, ROUGHNESSES, COSINES, TERMS), the series in the azimuth.
        mean: (ANISOTROPIES, ROUGHNESSES) the cosine-weighted mean over the hemisphere.

    The roughness is that of the mean of both widths; see `interface_albedo`.
    """

    albedo: np.ndarray
    mean: np.ndarray


def anisotropy(u: Any, v: Any) -> Any:
    """(u - v) / (u + v) of two widths."""
    return (u - v) / (u + v)


@functools.cache
def tables() -> Tables:
    """The tables, which take some seconds the first time."""
    alphas, cosine = albedo_axes.nodes()
    albedo = np.empty((ANISOTROPIES, len(alphas), len(cosine), TERMS))
    series = np.cos(2 * np.outer(_AZIMUTHS, np.arange(TERMS)))
    fit = np.linalg.pinv(series)
    for i, ratio in enumerate(np.linspace(0, MOST, ANISOTROPIES)):
        for j, alpha in enumerate(alphas):
            widths = alpha * (1 + ratio), alpha * (1 - ratio)
            values = [_albedo(widths, cosine, azimuth) for azimuth in _AZIMUTHS]
            albedo[i, j] = (fit @ np.stack(values)).T
    mean = albedo_axes.hemisphere_mean(albedo[..., 0])
    return Tables(albedo.astype(np.float32), mean.astype(np.float32))


def _albedo(widths: tuple[float, float], cosine: np.ndarray, azimuth: float) -> np.ndarray:
    """Share (N,) of the light from directions of given cosines (N,) that leaves at once.

    A quadrature over visible facets. Source: Dupuy and Benyoub 2023, listing 1.
    """
    (u, v), (turn, height, weight) = widths, interface_albedo.facet_nodes()
    sine = np.sqrt(1 - cosine**2)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine])[..., None]
    stretched = wi * np.array([u, v, 1.0])[:, None, None]
    stretched = stretched / np.linalg.norm(stretched, axis=0)
    z = height * (1 + stretched[2]) - stretched[2]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    x = u * (across * np.cos(turn) + stretched[0])
    y = v * (across * np.sin(turn) + stretched[1])
    m = np.stack([x, y, z + stretched[2]])
    m = m / np.linalg.norm(m, axis=0)
    wo = 2 * np.clip((wi * m).sum(axis=0), 0, 1) * m - wi
    slope2 = ((u * wo[0]) ** 2 + (v * wo[1]) ** 2) / np.maximum(wo[2], 1e-9) ** 2
    masking = np.where(wo[2] > 0, 2 / (1 + np.sqrt(1 + slope2)), 0.0)
    return masking @ weight
