"""Directional albedos of rough interfaces of two GGX widths, as `albedos` has those of one.

The axes of the tables are the index, the quotient of the larger to the smaller width, the larger
width, the azimuth and the cosine. The coordinate of the azimuth is linear in the width along it, on
which masking depends.
"""

import functools
import math
from collections.abc import Callable
from typing import Any

import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core import albedos
from urushi.core.albedos import BELOW, COSINES
from urushi.core.microfacet import pair
from urushi.core.namespace import NUMPY, Components, Namespace

#: Nodes of the quotient and of the azimuth.
QUOTIENTS, TURNS = 12, 9

#: Every how many nodes of the index below one and from one have tables of two widths.
STEPS = 4, 3


def indexnodes() -> np.ndarray:
    """The relative indices of the nodes."""
    etas = albedos.indexnodes()
    return np.concatenate([etas[: BELOW : STEPS[0]], etas[BELOW :: STEPS[1]]])


def index_coordinate(eta: Any, xp: Namespace = NUMPY) -> Any:
    """Coordinate of an index in [0, 1]; see `albedos.index_coordinate`."""
    place = albedos.index_coordinate(eta, xp) * (albedos.INDICES - 1)
    below = xp.minimum(place, BELOW - 1) / STEPS[0]
    above = xp.maximum(place - BELOW, 0) / STEPS[1]
    return xp.where(eta < 1, below, (BELOW - 1) // STEPS[0] + 1 + above) / (len(indexnodes()) - 1)


def coordinates(w: Any, widths: Any, xp: Namespace = NUMPY) -> list:
    """Coordinates in [0, 1] of the azimuth of a direction, the larger width, and the quotient.

    w: None in tables without its axes.
    """
    u, v = pair(widths)
    large, small = xp.maximum(u, v), xp.minimum(u, v)
    quotient = xp.log(large / small)
    place = [albedos.roughness_coordinate(large, xp), quotient / math.log(1 / MIN_ALPHA)]
    if w is None:
        return place
    x2, y2 = w.x * w.x, w.y * w.y
    least = 1e-12 * (small * small)  # the normal has no azimuth
    along = xp.sqrt((u * u * x2 + v * v * y2 + least) / (x2 + y2 + 1e-12))
    turn = (along - small) / xp.maximum(large - small, 1e-6 * small)
    return [xp.clip(turn, 0, 1), *place]


def cos2_at(turn: np.ndarray, quotients: np.ndarray) -> np.ndarray:
    """Squared cosines (Q, T), to the larger width, of azimuths of coordinates (T,).

    quotients: (Q,) of the larger to the smaller width.
    """
    narrow = 1 / np.maximum(quotients[:, None], 1.001)
    return ((narrow + turn * (1 - narrow)) ** 2 - narrow**2) / (1 - narrow**2)


def turn_weights(count: int, quotients: np.ndarray) -> np.ndarray:
    """Weights (Q, count) of nodes of the azimuth in the mean over it of a table linear between."""
    angle = (np.arange(1024) + 0.5) * (np.pi / 2048)
    w = Components(np.cos(angle), np.sin(angle), 0 * angle)
    place = [
        coordinates(w, Widths(np.float64(quotient), np.float64(1.0)))[0] * (count - 1)
        for quotient in quotients
    ]
    return np.maximum(1 - np.abs(np.stack(place)[:, None] - np.arange(count)[:, None]), 0).mean(2)


@functools.cache
def tables(eta: float | None = None) -> albedos.Tables:
    """The tables, see `albedos.tables`.

    eta: the only index; None: all of `indexnodes`, which takes seconds the first time.

    Returns:
        (I, QUOTIENTS, ROUGHNESSES, TURNS, COSINES); means have neither cosine nor azimuth.
    """
    etas = indexnodes() if eta is None else np.array([eta])
    quotients = (1 / MIN_ALPHA) ** np.linspace(0, 1, QUOTIENTS)
    return _tables(etas, quotients, albedos.nodes()[0])


def _tables(etas: np.ndarray, quotients: np.ndarray, alphas: np.ndarray) -> albedos.Tables:
    """`tables` at indices, quotients of the widths, and larger widths."""
    cos2 = cos2_at(np.linspace(0, 1, TURNS), quotients)
    grid = np.meshgrid(quotients, alphas, np.zeros(TURNS), indexing="ij")
    cos2 = np.broadcast_to(cos2[:, None], grid[0].shape)
    found = []
    for index in map(float, etas):
        cosine = albedos.nodes(index)[1]
        sine = np.sqrt(1 - cosine**2)
        q, large, x2, z = np.broadcast_arrays(*(x[..., None] for x in (*grid[:2], cos2)), cosine)
        w = np.stack([sine * np.sqrt(x2), sine * np.sqrt(1 - x2), z], -1).reshape(-1, 3)
        both = albedos.shares(w, Widths(large.ravel(), (large / q).ravel()), index)[:2]
        found.append([x.reshape(q.shape) for x in both])
    reflected, passed = np.moveaxis(np.array(found), 1, 0)
    means = (
        _hemisphere_mean(table, etas, quotients, entered)
        for entered in (False, True)
        for table in (reflected, passed)
    )
    values = reflected, passed, *means, np.empty(0)
    return albedos.Tables(*(x.astype(np.float32) for x in values))


def _hemisphere_mean(
    table: np.ndarray, etas: np.ndarray, quotients: np.ndarray, entered: bool
) -> np.ndarray:
    """Mean over diffuse light (I, QUOTIENTS, ROUGHNESSES); see `albedos.hemisphere_mean`."""
    over = np.einsum("iqrtc,qt->iqrc", table, turn_weights(TURNS, quotients))
    rows = over.reshape(len(over), -1, COSINES)
    return albedos.hemisphere_mean(rows, etas, entered=entered).reshape(over.shape[:-1])


@functools.cache
def surface_loss(
    widths: Widths, eta: float, mirrored: float = 0.0
) -> tuple[Callable[[np.ndarray], np.ndarray], float]:
    """The share of light that a coat's surface loses over a white base.

    mirrored: share of the base's light that it mirrors; the other is Lambertian.

    Returns:
        The share, a function of directions (N, 3), and its cosine-weighted mean; 0 for an index of
        1. That of one width is linear between the nodes of the cosine, as on the page.
    """
    if eta == 1:
        return lambda w: np.zeros(len(w)), 0.0
    large, small = max(pair(widths)), min(pair(widths))
    quotients, isotropic = np.array([large / small]), large == small
    above, below = (
        albedos.tables_of(np.array([index]), np.array([large]))
        if isotropic
        else _tables(np.array([index]), quotients, np.array([large]))
        for index in (eta, 1 / eta)
    )
    passed, reflected = (
        (1 - mirrored) * diffuse.item() + mirrored * entered.item()
        for diffuse, entered in (
            (below.passed_mean, below.passed_entered),
            (below.reflected_mean, below.reflected_entered),
        )
    )
    inside = passed / (1 - reflected)  # of the light that enters, what leaves at last

    def left(reflected: np.ndarray, passed: np.ndarray) -> np.ndarray:
        return np.clip(1 - reflected - inside * passed, 0, 1)

    table = left(above.reflected, above.passed)
    if isotropic:
        row, places = table.ravel(), np.linspace(0, 1, COSINES)
        mean = albedos.hemisphere_mean(table, np.array([eta])).item()
        return lambda w: np.interp(albedos.cosine_coordinate(w[:, 2], eta), places, row), mean
    mean = _hemisphere_mean(table, np.array([eta]), quotients, entered=False).item()
    return lambda w: left(*albedos.shares(w, widths, eta)[:2]), mean
