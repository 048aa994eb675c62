"""Tables of ln f over directions, for the rest of constant materials and for measured BRDFs.

A renderer looks up the rest of a constant material, because the decoder takes four times as long.
The numbers of a code are too few for a measured BRDF, so its material has a table of f itself. f is
interpolated linearly in three coordinates in [0, 1]:

    u = (ln(tan^2 theta_h + `TAN2_OFFSET`) - `LOWEST`) / (`HIGHEST` - `LOWEST`)
    v = sqrt(1 - cos theta_d)
    w = 1 - sqrt(1 - |d| / min(c, s))

with the half and the difference angle of Rusinkiewicz (1998), c = (cos_i + cos_o) / 2,
d = (cos_i - cos_o) / 2 and s = sin theta_h sin theta_d; neither c nor s is below |d|. The nodes are
densest for small half angles, where lobes are narrow, and where a direction grazes the surface.
Exchanging wi and wo leaves the coordinates the same to the bit. Rests of two GGX widths have the
four coordinates of `anisotropic_table`.

The table of a rest adds an error E of less than 0.05 % to most materials, and 0.15 % where a sharp
coat covers a sharp lobe; with two widths 0.1 to 0.5 % (`python -m benchmarks.quality.table`).
"""

import functools
import math
from collections.abc import Callable, Sequence

import numpy as np

from urushi.material import anisotropic_table
from urushi.nets.decoder import EMPTY_GAIN, MAX_LOG, MIN_LOG
from urushi.nets.features import MIN_COSINE, direction_features
from urushi.nets.networks import UrushiNetworks

#: Nodes in u, v and w.
SHAPE = (96, 32, 8)

#: Nodes of the table of a rest, by the number of GGX widths.
SHAPES: dict[int, tuple[int, ...]] = {1: SHAPE, 2: anisotropic_table.SHAPE}

#: Of the coordinate u.
TAN2_OFFSET = 1e-5
LOWEST, HIGHEST = math.log(TAN2_OFFSET), math.log(1e3)

#: Pairs that are evaluated at once.
BLOCK = 4096


def rest_table(networks: UrushiNetworks, latents: np.ndarray) -> np.ndarray | None:
    """ln f of the rests of codes (C, L): float32 (*`SHAPES[widths]`, C); None if there are none."""
    if (latents[:, networks.arch.lobe] <= EMPTY_GAIN).all():
        return None
    features = _node_features(networks.arch.widths)
    logs = [
        np.log(networks.rest(latents, features[start : start + BLOCK, None]))
        for start in range(0, len(features), BLOCK)
    ]
    return np.concatenate(logs).reshape(*SHAPES[networks.arch.widths], len(latents))


def table_of_values(f: np.ndarray) -> np.ndarray:
    """The table float16 (U, V, W, C) of a BRDF with values f (N, C) [1/sr] at `node_pairs`."""
    logs = np.log(np.maximum(f, math.exp(MIN_LOG)))
    return logs.clip(MIN_LOG, MAX_LOG).reshape(*SHAPE, -1).astype(np.float16)


def interpolated(table: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f float32 (N, C) [1/sr] of a table (U, V, W, C) for pairs (N, 3) above the horizon.

    The table may be one of four coordinates.
    """
    of = coordinates if table.ndim == 1 + len(SHAPE) else anisotropic_table.coordinates
    return interpolated_at(table, *of(wi, wo))


def interpolated_at(table: np.ndarray, *places: np.ndarray) -> np.ndarray:
    """f float32 (N, C) [1/sr] of a table (..., C) at its coordinates, arrays (N,)."""
    *shape, channels = table.shape
    rows = table.reshape(-1, channels)
    first: np.ndarray | int = 0
    shares = []
    for coordinate, count in zip(places, shape, strict=True):
        place = np.clip(coordinate, 0, 1) * (count - 1)
        index = np.minimum(place.astype(np.intp), count - 2)
        first = first * count + index
        shares.append((place - index.astype(place.dtype)).astype(np.float32)[:, None])
    values = [rows[first + step].astype(np.float32, copy=False) for step in corner_steps(shape)]
    for share in reversed(shares):
        values = [
            low + share * (high - low) for low, high in zip(values[::2], values[1::2], strict=True)
        ]
    return np.exp(values[0])


def corner_steps(shape: Sequence[int]) -> list[int]:
    """Steps from the first corner of a cell of a table to all corners, the last axis fastest."""
    return [int(np.ravel_multi_index(corner, shape)) for corner in np.ndindex(*[2] * len(shape))]


def coordinates(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The coordinates u, v, w (N,) of pairs (N, 3), in [0, 1] up to rounding."""
    x, y, z = ((wi[:, i] + wo[:, i]).astype(np.float64) for i in range(3))
    return coordinates_of_sum(x, y, z, wi[:, 2] - wo[:, 2])


def coordinates_of_sum(
    x: np.ndarray, y: np.ndarray, z: np.ndarray, difference: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`coordinates` of pairs with sums wi + wo = (x, y, z) and differences of cosines (...)."""
    across, z2 = x * x + y * y, np.maximum(z * z, 1e-18)
    squared = across + z2
    u = (np.log(across / z2 + TAN2_OFFSET) - LOWEST) / (HIGHEST - LOWEST)
    cos_d = np.minimum(0.5 * np.sqrt(squared), 1)
    sin2 = (1 - cos_d) * (1 + cos_d)
    reach = np.minimum(0.5 * z, np.sqrt(across / squared * sin2))
    size = np.clip(0.5 * np.abs(difference) / np.maximum(reach, 1e-9), 0, 1)
    return u, np.sqrt(1 - cos_d), 1 - np.sqrt(1 - size)


@functools.cache
def node_pairs() -> tuple[np.ndarray, np.ndarray]:
    """Pairs wi, wo float32 (N, 3) of the nodes, u slowest; cosines are at least `MIN_COSINE`."""
    return _raised_pairs(SHAPE, node_directions)


def _raised_pairs(
    shape: Sequence[int], directions: Callable[..., tuple[np.ndarray, np.ndarray]]
) -> tuple[np.ndarray, np.ndarray]:
    """The pairs of all nodes of a table, the last axis fastest; cosines at least `MIN_COSINE`.

    directions: from coordinates (N,), one array for each axis, to pairs wi, wo (N, 3).
    """
    axes = (np.linspace(0, 1, count) for count in shape)
    pairs = directions(*(x.ravel() for x in np.meshgrid(*axes, indexing="ij")))
    for w in pairs:
        w[:, 2] = np.maximum(w[:, 2], MIN_COSINE)
        w /= np.linalg.norm(w, axis=1, keepdims=True)
        w.flags.writeable = False
    return pairs


def node_directions(u: np.ndarray, v: np.ndarray, w: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A pair wi, wo float32 (N, 3) with the coordinates (N,).

    Where a coordinate means nothing, as w for equal directions, any pair of the same f is one.
    """
    tan2 = np.maximum(np.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET, 1e-9)
    cos_h = 1 / np.sqrt(1 + tan2)
    sin_h = np.sqrt(tan2) * cos_h
    cos_d = 1 - v * v
    sin_d = np.sqrt(np.maximum(1 - cos_d * cos_d, 0))
    both = sin_h * sin_d
    difference = (1 - (1 - w) ** 2) * np.minimum(cos_h * cos_d, both)
    cos_phi = np.where(both > 1e-12, difference / np.maximum(both, 1e-12), w)
    sin_phi = np.sqrt(np.maximum(1 - cos_phi**2, 0))
    along = np.stack([sin_h, np.zeros_like(sin_h), cos_h], axis=-1) * cos_d[..., None]
    across = np.stack([cos_phi * cos_h, sin_phi, -cos_phi * sin_h], axis=-1) * sin_d[..., None]
    return (along + across).astype(np.float32), (along - across).astype(np.float32)


@functools.cache
def _node_features(widths: int) -> np.ndarray:
    """The decoder's features float32 (N, D) of the nodes, for networks of one width or two."""
    if widths == 1:
        return direction_features(*node_pairs())
    pairs = _raised_pairs(anisotropic_table.SHAPE, anisotropic_table.node_directions)
    return direction_features(*pairs, widths)
