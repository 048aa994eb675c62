"""Images on hexagonal tiles that are turned, scaled and moved at random.

Mikkelsen, Practical Real-Time Hex-Tiling, JCGT 11(2), 2022, as MaterialX's node `hextiledimage`.
"""

import numpy as np

from urushi.openpbr.materialx.images import Look, sample
from urushi.openpbr.materialx.nodes import Call

#: Size of the texture in tiles.
_TILES = 2 * np.sqrt(3.0)

#: From uv to the grid of triangles, as rows.
_SKEW = np.array([[1, -np.tan(np.pi / 6)], [0, 2 * np.tan(np.pi / 6)]])


def _random(cell: np.ndarray) -> np.ndarray:
    """Two random numbers in [0, 1) for each cell (N, 2); shadertoy.com/view/4djSRW."""
    p = (cell + 0.12345)[:, [0, 1, 0]] * (0.1031, 0.1030, 0.0973) % 1
    p = p + (p * (p[:, [1, 2, 0]] + 33.33)).sum(-1, keepdims=True)
    return (p[:, :1] + p[:, 1:]) * p[:, [2, 1]] % 1


def _gain(x: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Schlick, Fast Alternatives to Perlin's Bias and Gain Functions, Graphics Gems IV, 1994."""
    a = (1 / np.clip(r, 0.001, 0.999) - 2) * (1 - 2 * x)
    return np.where(x < 0.5, x / (a + 1), (a - x) / (a - 1))


def hextiles(pixels: np.ndarray, uv: np.ndarray, call: Call) -> np.ndarray:
    """Values (N, channels) of an image (height, width, channels) at uv (N, 2).

    call: the node, whose inputs give the tiling and how much tiles differ.
    """
    uv = uv * call["tiling"]
    skewed = _TILES * uv @ _SKEW.T
    cell, (x, y) = np.floor(skewed), (skewed % 1).T
    upper = x + y >= 1
    corners = np.where(
        upper[:, None, None], [[1, 1], [1, 0], [0, 1]], [[0, 0], [0, 1], [1, 0]]
    )  # of the triangle around each point, the first opposite to its longest side
    near = np.stack([np.where(upper, x + y - 1, 1 - x - y), np.where(upper, 1 - y, y)])
    weights = np.concatenate([near, np.where(upper, 1 - x, x)[None]])
    values = []
    for k in range(3):
        corner = cell + corners[:, k]
        centre = corner / _TILES @ np.linalg.inv(_SKEW).T
        random = _random(corner)
        turn = _between(np.radians(call["rotationrange"]), random[:, :1] * call["rotation"])
        scale = 1 + (_between(call["scalerange"], random[:, 1:]) - 1) * call["scale"]
        shift = _between(call["offsetrange"], random * call["offset"])
        s, c = np.sin(turn), np.cos(turn)
        dx, dy = np.split(uv - centre, 2, axis=-1)
        there = np.concatenate([c * dx - s * dy, s * dx + c * dy], axis=-1) / scale
        values.append(sample(pixels, there + centre + shift, Look(), np.zeros(1)))
    tiles = np.stack(values)
    luma = (tiles[..., :3] * call["lumacoeffs"]).sum(-1)
    weighted = _weights(1 + (luma - 1) * call["falloffcontrast"], weights, call["falloff"])
    colour = (weighted[..., None] * tiles[..., :3]).sum(0)
    plain = _weights(np.ones_like(luma), weights, call["falloff"])
    return np.concatenate([colour, (plain[..., None] * tiles[..., 3:]).sum(0)], axis=-1)


def _between(ends: np.ndarray, t: np.ndarray) -> np.ndarray:
    return ends[..., :1] + (ends[..., 1:] - ends[..., :1]) * t


def _weights(factors: np.ndarray, weights: np.ndarray, falloff: np.ndarray) -> np.ndarray:
    """Weights (3, N) of the three tiles around each point, of sum 1."""
    w = factors * weights**7
    w = w / w.sum(0)
    w = np.where(falloff == 0.5, w, _gain(w, falloff))
    return w / w.sum(0)
