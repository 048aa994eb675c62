"""Energy-preserving Oren-Nayar: rough diffuse reflection that conserves energy.

Cosines are to the normal, in [0, 1]; `color` is the albedo of the facets and `roughness` the
parameter base_diffuse_roughness, both in [0, 1]; `xp` has the functions of the arrays.

Source: Portsmouth, Kutz and Hill 2025, EON: A practical energy-preserving rough diffuse BRDF; the
single-scattering term is Fujii's (2012).
"""

import math
from typing import Any

from urushi.core.namespace import NUMPY, Namespace

_FIRST = 0.5 - 2 / (3 * math.pi)
_SECOND = 2 / 3 - 28 / (15 * math.pi)


def single_albedo(cosine: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """Directional albedo of the single-scattering term for a facet albedo of one."""
    sine = xp.sqrt(xp.maximum(1 - cosine * cosine, 0))
    angle = xp.arccos(xp.clip(cosine, 0, 1))
    # (sine / cosine)(1 - sine^3) without the quotient: 1 - sine^2 = cosine^2.
    ratio = sine * cosine * (1 + sine + sine * sine) / (1 + sine)
    g = sine * (angle - sine * cosine) + 2 / 3 * (ratio - sine)
    return (1 + roughness * g / math.pi) / (1 + _FIRST * roughness)


def single_mean(roughness: Any) -> Any:
    """The cosine-weighted mean of `single_albedo` over the hemisphere."""
    return (1 + _SECOND * roughness) / (1 + _FIRST * roughness)


def single_over_azimuths(i: Any, o: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """The single-scattering term times pi for a facet albedo of one, its mean over the azimuth."""
    sines2 = xp.maximum(1 - i * i, 0) * xp.maximum(1 - o * o, 0)
    larger = xp.maximum(xp.maximum(i, o), 1e-7)
    shape = xp.sqrt(sines2) * (1 / larger - 1) / math.pi
    return (1 + roughness * shape) / (1 + _FIRST * roughness)


def deviation(roughness: Any) -> Any:
    """Deviation of a white BRDF from a Lambertian one, as a share of the deviation at roughness 1.

    It is the same for all directions.
    """
    return roughness * ((1 + _FIRST) / (1 + _FIRST * roughness))


def multiple_albedo(color: Any, roughness: Any) -> Any:
    """The albedo of light that is scattered more than once, in proportion to what the term lost."""
    mean = single_mean(roughness)
    return color * color * mean / (1 - color * (1 - mean))


def albedo(cosine: Any, color: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """Directional albedo of the BRDF, one for a colour of one."""
    single = single_albedo(cosine, roughness, xp)
    return color * single + multiple_albedo(color, roughness) * (1 - single)


def mean_albedo(color: Any, roughness: Any) -> Any:
    """The cosine-weighted mean of `albedo` over the hemisphere."""
    mean = single_mean(roughness)
    return color * mean + multiple_albedo(color, roughness) * (1 - mean)


def f(i: Any, o: Any, between: Any, color: Any, roughness: Any, xp: Namespace = NUMPY) -> Any:
    """The BRDF [1/sr], without cosine.

    i, o: cosines of wi and wo. between: the cosine between wi and wo.
    """
    s = between - i * o
    shape = xp.minimum(s, 0) + xp.maximum(s, 0) / xp.maximum(xp.maximum(i, o), 1e-7)
    single = color * (1 + roughness * shape) / (1 + _FIRST * roughness)
    lost = [1 - single_albedo(cosine, roughness, xp) for cosine in (i, o)]
    # For a roughness of zero nothing is lost, and the quotient is 0 / 0.
    share = lost[0] * lost[1] / xp.maximum(1 - single_mean(roughness), 1e-7)
    return (single + multiple_albedo(color, roughness) * share) / math.pi
