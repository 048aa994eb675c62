"""The shape of a loafer, the right one: every part a closed surface around the foot.

u runs around the foot, from the heel's back along the outer side to the toe and back along the
inner side; v across the part. The toe points to +x, the outer side to -y. Fronts are outwards.
"""

from collections.abc import Callable

import numpy as np

from gallery.stage import smoothstep

#: The sole seen from above: control points (x, y) of a closed B-spline, from the heel's back along
#: the outer side.
OUTLINE = np.array([
    (-1.32, 0.00), (-1.27, -0.25), (-1.02, -0.41), (-0.60, -0.42), (-0.10, -0.38), (0.40, -0.44),
    (0.85, -0.55), (1.25, -0.53), (1.60, -0.33), (1.76, -0.02), (1.66, 0.24), (1.38, 0.43),
    (0.95, 0.53), (0.50, 0.47), (0.10, 0.31), (-0.30, 0.27), (-0.70, 0.36), (-1.04, 0.38),
    (-1.27, 0.25),
])  # fmt: skip
#: The heel seen from above, in the same order.
HEEL = np.array([
    (-1.32, 0.00), (-1.27, -0.25), (-1.02, -0.41), (-0.74, -0.42), (-0.54, -0.42), (-0.53, -0.20),
    (-0.56, 0.00), (-0.53, 0.18), (-0.54, 0.36), (-0.74, 0.36), (-1.04, 0.38), (-1.27, 0.25),
])  # fmt: skip
#: The opening: its centre along the foot, half length, half width.
COLLAR_X, COLLAR_LENGTH, COLLAR_WIDTH = -0.58, 0.66, 0.31
SOLE, LEATHER = 0.11, 0.035


def outline(u: np.ndarray, control: np.ndarray = OUTLINE) -> np.ndarray:
    """Points (..., 2) of an outline, by default the sole's: a uniform cubic B-spline."""
    count = len(control)
    at = (u % 1.0) * count
    first = np.floor(at).astype(int)
    s = (at - first)[..., None]
    a, b, c, d = (control[(first + k - 1) % count] for k in range(4))
    return (
        (1 - s) ** 3 * a
        + (3 * s**3 - 6 * s**2 + 4) * b
        + (-3 * s**3 + 3 * s**2 + 3 * s + 1) * c
        + s**3 * d
    ) / 6


def lift(x: np.ndarray) -> np.ndarray:
    """Height of the sole's underside: the heel's rise, and the toe's spring."""
    return 0.26 * smoothstep(0.55, -0.55, x) + 0.09 * smoothstep(0.85, 1.9, x)


def collar(u: np.ndarray) -> np.ndarray:
    """Points (..., 3) of the opening's edge: high at the heel and at the throat."""
    angle = 2 * np.pi * (u + 0.5)  # u = 0 is the heel's back
    forward = (np.cos(angle) + 1) / 2
    x = COLLAR_X + COLLAR_LENGTH * np.cos(angle)
    y = COLLAR_WIDTH * np.sin(angle) * (1 - 0.25 * forward**2)
    z = 0.98 + 0.14 * smoothstep(0.5, 0, forward) + 0.10 * smoothstep(0.55, 1, forward)
    return np.stack(np.broadcast_arrays(x, y, z), axis=-1)


def upper(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Points (..., 3) from the welt over the instep to the collar: a Bézier curve for every u."""
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    flat, top = outline(u), collar(u)
    bottom = np.concatenate([0.97 * flat, (lift(flat[..., 0]) + SOLE)[..., None]], axis=-1)
    front = smoothstep(0.25, 0.5, 0.5 - np.abs(u - 0.5))[..., None]  # 1 at the toe, 0 at the heel
    outwards = np.stack([0.10 * flat[..., 0], 0.16 * flat[..., 1], np.zeros(u.shape)], axis=-1)
    rise = np.zeros((*u.shape, 3))
    rise[..., 2:] = 0.34 + 0.12 * front
    below = bottom + 0.6 * outwards * (1 - 0.4 * front) + rise
    descent = np.array([0.0, 0.0, -0.42]) + front * np.array([0.62, 0.0, 0.20])
    spread = np.zeros((*u.shape, 3))
    spread[..., 1] = 0.35 * front[..., 0] * flat[..., 1]
    above = top + descent + spread
    t = v[..., None]
    s = 1 - t
    return s**3 * bottom + 3 * s**2 * t * below + 3 * s * t**2 * above + t**3 * top


def lining(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Points (..., 3) from the collar down the inside to the middle of the insole."""
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    top = collar(u)
    flat = outline(u) * 0.86
    inset = top * [1, 0.9, 1]
    floor = np.concatenate([flat, (lift(flat[..., 0]) + SOLE + 0.06)[..., None]], axis=-1)
    middle = np.broadcast_to(np.array([0.1, 0.0, 0.30]), floor.shape)
    down = smoothstep(0, 0.6, v)[..., None]
    wall = inset + (floor - inset) * down
    return wall + (middle - wall) * smoothstep(0.6, 1.0, v)[..., None]


def piping(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A roll of leather along the collar."""
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    centre = collar(u)
    ahead = collar(u + 1e-3) - collar(u - 1e-3)
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    side = np.cross(ahead, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    up = np.cross(side, ahead)
    angle = 2 * np.pi * v[..., None]
    return centre + LEATHER * (np.cos(angle) * side + np.sin(angle) * up)


def sole(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """A plate under the whole foot, with rounded edges."""
    return _plate(u, v, outline(u) * 1.045, lift, lambda x: lift(x) + SOLE)


def heel(u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """The block under the heel, straight in front."""
    return _plate(u, v, outline(u, HEEL) * 1.03, lambda x: 0 * x, lambda x: lift(x) + 0.02)


def _plate(
    u: np.ndarray, v: np.ndarray, flat: np.ndarray, low: Callable, high: Callable
) -> np.ndarray:
    """From the middle of the underside around the edge to the middle of the top."""
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    angle = np.pi * (np.clip((v - 0.4) / 0.2, 0, 1) - 0.5)  # around the edge
    across = np.minimum(np.minimum(v, 1 - v) / 0.4, 1) * 0.97 + 0.03 * np.cos(angle)
    middle = np.array([-0.9, 0.0])
    points = middle + (flat - middle) * across[..., None]
    x = points[..., 0]
    z = low(x) + (high(x) - low(x)) * (0.5 + 0.5 * np.sin(angle))
    return np.concatenate([points, z[..., None]], axis=-1)


#: Every part, by name.
SHAPES: dict[str, Callable[[np.ndarray, np.ndarray], np.ndarray]] = {
    "upper": upper,
    "lining": lining,
    "collar": piping,
    "sole": sole,
    "heel": heel,
}
