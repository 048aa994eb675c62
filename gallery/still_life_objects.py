"""Outlines and patterns of the objects in the still life.

Patterns are functions of the texels' positions in space, so that the mapping does not stretch them.
"""

import numpy as np

from gallery import noise
from gallery.grids import grid
from gallery.mesh import Mesh, Profile, surface
from gallery.stage import smoothstep


def texels(profile: Profile, rows: int) -> np.ndarray:
    """Positions (rows, 2 rows, 3) of the centres of a turned shape's texels."""
    u, v = (np.arange(2 * rows) + 0.5) / (2 * rows), (np.arange(rows) + 0.5) / rows
    return surface(profile, u[None, :], v[:, None])[0]


def wood(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Reflectance (H, W, 3) of boards along x, each 0.55 wide, at points x, y (H, W)."""
    board = np.floor(y / 0.55)
    points = np.stack([x * 0.35 + 7 * board, y * 2.2 + 3.1 * board, 5 * board], axis=-1)
    rings = points[..., 1] * 3 + 1.8 * noise.fractal(points * [0.7, 0.6, 1], 4, seed=1)
    band = 0.5 + 0.5 * np.sin(2 * np.pi * rings)
    fibre = noise.fractal(points * [2.5, 30, 1], 2, seed=5)
    shade = np.clip(0.35 + 0.35 * band + 0.35 * fibre + 0.12 * np.sin(5.7 * board), 0, 1)
    gap = smoothstep(0.012, 0.004, np.abs((y / 0.55) % 1 - 0.5) * -1 + 0.5)
    dark, light = np.array([0.11, 0.045, 0.02]), np.array([0.36, 0.17, 0.075])
    return (dark + (light - dark) * shade[..., None]) * (1 - 0.8 * gap[..., None])


def clay(points: np.ndarray) -> np.ndarray:
    """Reflectance of a clay vase with grasses painted on it in iron."""
    angle = np.arctan2(points[..., 1], points[..., 0])
    z = points[..., 2]
    ink = np.zeros(z.shape)
    rng = np.random.default_rng(12)
    for _ in range(34):
        foot, height = rng.uniform(-np.pi, np.pi), rng.uniform(0.9, 1.75)
        lean, width = rng.uniform(-0.5, 0.5), rng.uniform(0.012, 0.026)
        t = np.clip((z - 0.25) / (height - 0.25), 0, 1)
        off = (angle - foot - lean * t**2 + np.pi) % (2 * np.pi) - np.pi
        blade = width * np.sqrt(np.clip(t * (1 - t) * 4, 0, 1)) * 2.2
        ink = np.maximum(ink, smoothstep(0.006, -0.006, np.abs(off) * 0.6 - blade) * (t > 0))
    speckle = smoothstep(0.16, 0.10, noise.cells(points * 9, seed=3)[0])
    ground = np.array([0.74, 0.69, 0.58]) * (1 + 0.12 * noise.fractal(points * 3, 4)[..., None])
    iron = np.clip(ink + 0.6 * speckle, 0, 1)[..., None]
    return np.clip(ground + (np.array([0.13, 0.07, 0.035]) - ground) * iron, 0, 1)


def celadon(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Optical depth and albedo of a glaze that is thin on the rim and thick near the foot."""
    z = points[..., 2]
    run = 0.16 * noise.fractal(points * [3.2, 3.2, 0.8], 4, seed=8)
    thick = 0.25 + 0.5 * smoothstep(2.0, 1.0, z) + 1.2 * smoothstep(0.75, 0.25, z + run)
    thick *= smoothstep(0.02, 0.10, z + 0.4 * run) + 0.15
    depth = thick[..., None] * np.array([1.5, 0.55, 0.85])
    deep = smoothstep(0.4, 1.6, thick)[..., None]
    pale, jade = np.array([0.72, 0.92, 0.80]), np.array([0.30, 0.80, 0.58])
    return depth, pale + (jade - pale) * deep


def waves(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Optical depth and albedo of lacquer on a plate with golden seigaiha (a pattern of waves)."""
    x, y = points[..., 0], points[..., 1]
    radius = np.hypot(x, y)
    size = 0.20
    line = np.zeros(x.shape)
    # Scales overlap: each row hides the parts of the rows behind it.
    for row in np.arange(np.ceil(y.max() / size * 2), np.floor(y.min() / size * 2) - 3, -1):
        centre_y = row * size / 2
        shift = (row % 2) * size
        off_x = (x - shift + size) % (2 * size) - size
        distance = np.hypot(off_x, y - centre_y) / size
        arcs = np.maximum.reduce(
            [smoothstep(0.055, 0.025, np.abs(distance - r)) for r in (0.94, 0.66, 0.38)]
        )
        line = np.where(distance < 1, arcs, line)
    middle = smoothstep(0.60, 0.585, radius)
    gold = line * middle
    for r, w in ((0.615, 0.012), (0.845, 0.02)):
        gold = np.maximum(gold, smoothstep(w, 0.6 * w, np.abs(radius - r)))
    red = np.array([2.6, 5.0, 5.4]), np.array([0.85, 0.14, 0.05])
    black = np.array([4.0, 4.6, 5.0]), np.array([0.20, 0.05, 0.03])
    bare = np.array([0.03, 0.08, 0.2]), np.array([0.9, 0.8, 0.6])
    inner = middle[..., None]
    depth, albedo = (b + (r - b) * inner for r, b in zip(red, black, strict=True))
    amount = gold[..., None]
    depth = np.exp(np.log(depth) + (np.log(bare[0]) - np.log(depth)) * amount)
    return depth, albedo + (bare[1] - albedo) * amount


def hammered(points: np.ndarray) -> np.ndarray:
    """Heights of hammered metal at points (..., 3), in the shape's unit of length."""
    first, _ = noise.cells(points * 7, seed=6)
    return 0.016 * np.minimum(first, 0.75) ** 2 / 0.4


def skin(points: np.ndarray, *, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Albedo and optical depth of an apple's skin with streaks, red on one side."""
    angle = np.arctan2(points[..., 1], points[..., 0])
    streak = noise.fractal(
        np.stack([3 * np.cos(angle), 3 * np.sin(angle), 0.6 * points[..., 2]], axis=-1) * 2.2,
        3,
        seed=30 + seed,
    )
    blush = smoothstep(-0.35, 0.55, 0.75 * np.cos(angle) + 0.55 * streak + 0.25)
    dots = smoothstep(0.17, 0.09, noise.cells(points * 17, seed=60 + seed)[0])
    green, red, pale = np.array([[0.72, 0.80, 0.16], [0.82, 0.10, 0.06], [0.95, 0.85, 0.5]])
    albedo = green + (red - green) * blush[..., None]
    albedo = albedo + (pale - albedo) * 0.7 * dots[..., None]
    depth = np.array([0.8, 0.9, 1.8]) * (1 - blush[..., None])
    depth = depth + np.array([1.2, 3.6, 3.8]) * blush[..., None]
    return albedo, depth * (1 - 0.5 * dots[..., None])


def stem() -> Mesh:
    """An apple's stem: a bent, tapering tube."""
    along, around = np.linspace(0, 1, 17)[:, None], np.linspace(0, 2 * np.pi, 17)[None, :]
    radius = 0.012 + 0.010 * along**4
    x = 0.06 * along**2 + radius * np.cos(around)
    y = radius * np.sin(around)
    return grid(np.stack(np.broadcast_arrays(x, y, 0.36 + 0.26 * along), axis=-1), closed=True)


# Outlines: radius and height, from the middle of the foot to the top.
VASE = [
    (0.00, 0.04), (0.18, 0.04), (0.27, 0.03), (0.31, 0.00), (0.36, 0.00), (0.38, 0.05),
    (0.42, 0.20), (0.56, 0.50), (0.66, 0.85), (0.67, 1.12), (0.58, 1.40), (0.38, 1.62),
    (0.24, 1.78), (0.20, 1.95), (0.22, 2.12), (0.30, 2.24), (0.335, 2.285), (0.325, 2.30),
    (0.29, 2.28), (0.20, 2.16), (0.16, 1.95), (0.16, 1.80), (0.10, 1.70), (0.00, 1.68),
]  # fmt: skip
PLATE = [
    (0.00, 0.03), (0.30, 0.03), (0.40, 0.02), (0.43, 0.00), (0.46, 0.00), (0.48, 0.03),
    (0.62, 0.07), (0.80, 0.12), (0.87, 0.145), (0.885, 0.16), (0.87, 0.175), (0.80, 0.165),
    (0.66, 0.13), (0.58, 0.095), (0.50, 0.085), (0.30, 0.08), (0.00, 0.08),
]  # fmt: skip
BOWL = [
    (0.00, 0.03), (0.20, 0.03), (0.26, 0.02), (0.28, 0.00), (0.31, 0.00), (0.33, 0.04),
    (0.46, 0.10), (0.64, 0.24), (0.74, 0.42), (0.77, 0.54), (0.785, 0.57), (0.775, 0.585),
    (0.755, 0.57), (0.71, 0.42), (0.61, 0.27), (0.44, 0.14), (0.20, 0.09), (0.00, 0.08),
]  # fmt: skip
APPLE = [
    (0.00, 0.09), (0.04, 0.07), (0.10, 0.01), (0.16, 0.00), (0.24, 0.04), (0.31, 0.16),
    (0.345, 0.30), (0.335, 0.44), (0.27, 0.55), (0.17, 0.59), (0.09, 0.57), (0.03, 0.48),
    (0.00, 0.44),
]  # fmt: skip
