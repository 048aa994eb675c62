"""Colours that share one random walk: single-sample spectral MIS (Wilkie et al. 2014).

Free flights and phase functions are sampled for one channel, the hero, which is chosen uniformly
per walk. Besides its throughput (f / density of the hero), a walk carries the density of every
channel relative to the hero's. Dividing contributions by the mean of these densities is the
balance heuristic over channels. For a scalar colour type, `hero` is None and all ratios are the
constant 1, so that none of this is compiled.
"""

from typing import Any

import drjit as dr

from urushi.physics import phase


def pick(color: type, u: Any) -> Any:
    """The index of the hero channel from a uniform number; None if `color` is a scalar type."""
    if dr.depth_v(color) < 2:
        return None
    count = dr.size_v(color)
    return dr.minimum(dr.uint32_array_t(type(u))(u * count), count - 1)


def of_hero(value: Any, hero: Any) -> Any:
    """The hero's component of a colour; a scalar stands for all channels."""
    if hero is None or dr.depth_v(type(value)) < 2:
        return value
    result = value[0]
    for i in range(1, dr.size_v(type(value))):
        result = dr.select(hero == i, value[i], result)
    return result


def flight_ratio(sigma_t: Any, distance: Any, in_medium: Any, hero: Any) -> Any:
    """Each channel's density of a free flight relative to the hero's, which was sampled."""
    if hero is None:
        return 1
    sigma_hero = of_hero(sigma_t, hero)
    ratio = dr.exp((sigma_hero - sigma_t) * distance)
    return ratio * dr.select(in_medium, sigma_t / sigma_hero, 1)


def phase_ratio(cos_theta: Any, g: Any, hero: Any) -> Any:
    """Each channel's phase function relative to the hero's, which was sampled."""
    if hero is None:
        return 1
    return phase.hg(cos_theta, g) / phase.hg(cos_theta, of_hero(g, hero))


def mean(spectral: Any, hero: Any) -> Any:
    """The mean relative density of all channels."""
    return 1 if hero is None else dr.mean(spectral)


def mixture(density: Any, spectral: Any, hero: Any) -> Any:
    """The density of a vertex's sample over all choices of the hero, given the walk so far.

    Weights that combine techniques must use this density. With the hero's own density they would
    differ between heroes, and the weights of the techniques would not sum to one.
    """
    return density if hero is None else dr.mean(spectral * density) / dr.mean(spectral)


def strongest(throughput: Any, hero: Any) -> Any:
    """The largest component of a throughput."""
    return throughput if hero is None else dr.max(throughput)
