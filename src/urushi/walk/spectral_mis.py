"""Colours that share one random walk: single-sample spectral MIS (Wilkie et al. 2014).

Free flights and phase functions are sampled for one channel, the hero, which is chosen uniformly
per walk. Besides its throughput (f / density of the hero), a walk carries the density of every
channel relative to the hero's. Dividing contributions by the mean of these densities is the
balance heuristic over channels. For a scalar colour type, `hero` is None and all ratios are the
constant 1, so that none of this is compiled.
"""

from typing import Any

import drjit as dr


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


def ratio(density: Any, hero: Any) -> Any:
    """Each channel's density of a direction relative to the hero's, which was sampled."""
    return 1 if hero is None else density / of_hero(density, hero)


def connecting(sigma_t: Any, distance: Any, hero: Any) -> tuple[Any, Any]:
    """The optical depth by which places of connections are drawn, and what collides within.

    In colours it is not 0, as places of a clear hero connect the other channels.
    """
    if hero is None:
        return sigma_t, 1 - dr.exp(-sigma_t * distance)
    sigma_t = dr.maximum(sigma_t, 1e-3)
    return sigma_t, dr.maximum(1 - dr.exp(-sigma_t * distance), 1e-7)


def mean(spectral: Any, hero: Any) -> Any:
    """The mean relative density of all channels."""
    return 1 if hero is None else dr.mean(spectral)


def mixture(density: Any, spectral: Any, hero: Any) -> Any:
    """The density of a vertex's sample over all choices of the hero, given the walk so far.

    Weights that combine techniques must use this density. With the hero's own density they would
    differ between heroes, and the weights of the techniques would not sum to one.
    """
    if hero is None:
        return density
    total = dr.mean(spectral)  # 0 at a place that no channel's collisions reach
    return dr.select(total > 0, dr.mean(spectral * density) / total, 0)


def greatest(value: Any) -> Any:
    """The largest component of a colour; a float as it is."""
    return dr.max(value) if dr.depth_v(value) > 1 else value


def least(value: Any) -> Any:
    """The smallest component of a colour; a float as it is."""
    return dr.min(value) if dr.depth_v(value) > 1 else value
