"""Tables of coats over materials that have a table, by light transport through the coat.

A code is too coarse for a measured BRDF, and a coat over the code inherits its error. Light
transport (`urushi.material.coated_values`) is therefore computed for a sixth of a table's nodes.
Between them, logarithms are cubic (`core.table.interpolated_nodes`). Under indices below one, all
nodes are computed. The table holds g of `nets.transmittance`: f without the lobe of the coat,
divided by T(wi) T(wo), which has the edges of total reflection.
"""

from collections.abc import Sequence

import numpy as np

from urushi.checks import CoatParameters
from urushi.core import table
from urushi.material import adding, energy
from urushi.material.coated_values import HALF, NARROW, WIDE, coated_values, passed_twice
from urushi.material.material import Material
from urushi.material.substrate import Substrate, of_material
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import both_ways, polar_nodes

#: Numbers of points in slabs, see `coated_values`.
SLAB_POINTS = 64, 64, 64

#: Cosines at which the albedo is limited.
LIMITED_COSINES = np.array([1.0, 0.9, 0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02, 0.01])

#: Rounds of that limit.
ROUNDS = 4


def rest_at_nodes(
    below: Substrate,
    channels: np.ndarray,
    interfaces: np.ndarray,
    media: np.ndarray,
    factor: np.ndarray,
    points: tuple[int, int, int] = (WIDE, NARROW, HALF),
    knots: table.Knots = (),
) -> np.ndarray:
    """f divided by a factor, float32 (N, C), at the nodes of coats over a substrate.

    Args:
        channels: (C,) of the substrate.
        interfaces, media, points: as of `coated_values`; a slab has `SLAB_POINTS`.
        factor: (N, C) or (N, 1) with f's edges, so that the quotient is smooth between the nodes.
        knots: of the table, for slabs; edges of total reflection are there.
    """
    count = len(channels)
    every = table.node_pairs(knots)
    result = np.empty((len(every[0]), count), np.float32)

    def at(pairs: Sequence[np.ndarray], chosen: np.ndarray) -> np.ndarray:
        parts = channels[chosen], interfaces[:, chosen], media[:, chosen], pairs[0], pairs[1]
        return coated_values(below, *parts, points=points)

    factor = np.broadcast_to(factor, result.shape)
    # Without an interface, a pair costs little. Inner edges of total reflection are too steep for
    # cubics, but for those at knots.
    whole = interfaces[1] == 1 if knots else interfaces[1] <= 1
    if whole.any():
        result[:, whole] = at(every, whole) / factor[:, whole]
    if not whole.all():
        known = factor[:, ~whole].reshape(*table.SHAPE, -1)[np.ix_(*table.known_nodes(knots))]
        values = at(table.known_pairs(knots), ~whole).reshape(known.shape)
        values /= known
        result[:, ~whole] = table.interpolated_nodes(values, knots).reshape(len(result), -1)
    return result


def coated_table(bottom: Material, coat: CoatParameters, lobe: np.ndarray) -> np.ndarray:
    """The table float16 (U, V, W, C) of a coated material, without the lobe of its interface.

    Table and lobe have a directional albedo of at most 1, or of at most the bottom's if the bottom
    gains energy.

    Args:
        bottom: of C channels or one.
        coat: numbers or arrays (C,), with one width.
        lobe: (C, N) of the interface. No table has it: near the horizon it changes too fast.
    """
    own = lobe.astype(np.float64)

    def top(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return lobes.f(own, wi[:, None].astype(np.float64), wo[:, None].astype(np.float64))

    below = of_material(bottom)
    *columns, channels = np.broadcast_arrays(*coat, np.arange(below.channels))
    parameters = np.stack(columns).astype(np.float64)
    passed = passed_twice(CoatParameters(*parameters), *table.node_pairs())
    rest = rest_at_nodes(below, channels, parameters[:2], parameters[2:], passed)
    of_rest = _albedos_of_values(rest, lobe)
    of_top = adding.albedos(top, LIMITED_COSINES, polar_nodes(own))
    ceiling = np.full(rest.shape[1], 1 - energy.MARGIN)
    if (of_rest + of_top > ceiling).any():
        ceiling = ceiling + (below.ceiling[channels] - 1)
    allowed = np.maximum(ceiling - of_top, energy.LEAST_REST)
    for _ in range(ROUNDS):  # a factor at the nodes is a smaller change between them
        factors = np.minimum(allowed / np.maximum(of_rest, energy.LEAST_ALBEDO), 1)
        if (factors == 1).all():
            break
        at_limited = LIMITED_COSINES[::-1], factors[::-1]
        sides = (table.interpolated_columns(w[:, 2], *at_limited) for w in table.node_pairs())
        rest *= np.minimum(*sides).astype(np.float32)  # the lesser one keeps f reciprocal
        of_rest = _albedos_of_values(rest, lobe)
    return table.table_of_values(rest)


def _albedos_of_values(rest: np.ndarray, lobe: np.ndarray) -> np.ndarray:
    """Albedos (N, C) at `LIMITED_COSINES` of the table of a rest (M, C) at `node_pairs`."""
    own = table.table_of_values(rest).astype(np.float32)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return table.interpolated(own, wi, wo) * both_ways(lobe, wi[:, None], wo[:, None])

    return adding.albedos(f, LIMITED_COSINES)
