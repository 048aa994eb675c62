"""The woods and the varnish of a violin as textures: spruce, flamed maple, purfling, wear."""

from dataclasses import replace

import numpy as np

from gallery import noise
from gallery.mesh import Mesh
from gallery.solids import in_region, merged, moved
from gallery.stage import smoothstep
from gallery.violin_neck import maple_parts as neck_parts
from gallery.violin_shape import LENGTH, RIBS, WIDTH, Arching, plate, ribs

#: Regions of the maple's textures in u: half of the back from the middle, whose other half is its
#: mirror image; the ribs; the neck with the scroll.
BACK, SIDES, NECK = (0.0, 0.48), (0.51, 0.66), (0.69, 1.0)

#: Distance of the purfling from the edge, width of its light strip and of each dark one [mm].
PURFLING, LIGHT, DARK = 3.9, 0.9, 0.5

#: Linear colours of the woods without varnish.
SPRUCE, LATE = np.array([0.78, 0.58, 0.34]), np.array([0.50, 0.29, 0.12])
MAPLE, FLAME = np.array([0.80, 0.56, 0.31]), np.array([0.40, 0.19, 0.07])
BLACK = np.array([0.03, 0.022, 0.018])


def maple_parts(arching: Arching) -> Mesh:
    """Back, ribs, neck and scroll as one mesh, whose texture coordinates are in their regions."""
    back = plate(arching, holes=False)
    back = moved(back, np.diag([1, 1, -1]), (0, 0, -RIBS))
    back = replace(
        back, uv=np.abs(back.uv * 2 - np.array([1, 0], np.float32)) / np.array([1, 2], np.float32)
    )
    sides = ribs()
    sides = replace(sides, uv=sides.uv[:, ::-1])
    necks = [in_region(mesh, (NECK[0], 0), (NECK[1], 1)) for mesh in neck_parts()]
    parts = [
        in_region(back, (BACK[0], 0), (BACK[1], 1)),
        in_region(sides, (SIDES[0], 0), (SIDES[1], 1)),
    ]
    return merged([*parts, *necks])


def spruce(arching: Arching, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Colour (H, W, 3) and depth of the varnish (H, W) of the front, for `rows` texels along it."""
    x, y = _plane(rows)
    bend = noise.fractal(np.stack([x / 90, y / 220, 0 * x], axis=-1), 2, seed=21)
    across = np.abs(x) + 3.0 * bend + 1.5  # two halves of one wedge, mirrored
    rings = 56 * (1 - np.exp(-across / 62))  # close in the middle, wide at the edges
    rings = rings + 0.35 * noise.fractal(np.stack([across / 9, y / 300, 0 * x], axis=-1), 2, seed=3)
    part = rings % 1.0
    late = smoothstep(0.35, 0.9, part) * smoothstep(1.0, 0.93, part)
    strong = 0.75 + 0.35 * noise.fractal(
        np.stack([np.floor(rings) * 7.7, y / 400, 0 * x], axis=-1), 1, seed=5
    )
    fibre = noise.fractal(np.stack([x / 0.8, y / 22, 0 * x], axis=-1), 3, seed=8)
    silk = noise.fractal(np.stack([x / 5, y / 1.6, 0 * x], axis=-1), 2, seed=9)
    amount = np.clip(0.72 * late * strong + 0.10 * fibre + 0.07 * silk, 0, 1)
    color = SPRUCE + (LATE - SPRUCE) * amount[..., None]
    return _inlaid(color, arching, x, y), _depth(arching, x, y, worn_at=(55, 300))


def flamed_maple(arching: Arching, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Colour (H, W, 3) and depth of the varnish (H, W) of `maple_parts`."""
    x, y = (half[:, half.shape[1] // 2 :] for half in _plane(rows))
    regions = [
        (BACK, _inlaid(_flames(x, y, 1), arching, x, y), _depth(arching, x, y, worn_at=(20, 250)))
    ]
    columns = round(x.shape[1] / (BACK[1] - BACK[0]))
    for region, wide, long, seed in ((SIDES, RIBS, 560.0, 2), (NECK, 60.0, 240.0, 3)):
        count = round((region[1] - region[0]) * columns)
        across = (np.arange(count) + 0.5) / count * wide
        points = np.meshgrid(across, (np.arange(rows) + 0.5) / rows * long)
        regions.append((region, _flames(points[0], points[1], seed), np.ones((rows, count))))
    color, depth = np.tile(MAPLE, (rows, columns, 1)), np.ones((rows, columns))
    for (low, _), part, thick in regions:
        first = round(low * columns)
        last = min(first + part.shape[1], columns)
        color[:, first:last], depth[:, first:last] = (
            part[:, : last - first],
            thick[:, : last - first],
        )
        if last < columns:  # the border's colour, for interpolation
            color[:, last : last + 4], depth[:, last : last + 4] = part[:, -1:], thick[:, -1:]
    return color, depth


def _plane(rows: int) -> tuple[np.ndarray, np.ndarray]:
    """x and y at the texels of a plate."""
    columns = round(rows * WIDTH / LENGTH)
    across = ((np.arange(columns) + 0.5) / columns - 0.5) * WIDTH
    return np.meshgrid(across, (np.arange(rows) + 0.5) / rows * LENGTH)


def _flames(x: np.ndarray, y: np.ndarray, seed: int) -> np.ndarray:
    """Colours of maple at points: waves of the fibres lie across them, mirrored at x = 0."""
    side = np.abs(x)
    sway = noise.fractal(np.stack([side / 45, y / 60, 0 * x], axis=-1), 2, seed=30 + seed)
    wave = (y - 0.30 * side) / 9.0 + 0.9 * sway
    bands = noise.fractal(np.stack([side / 60, wave, 0 * x], axis=-1), 2, seed=40 + seed)
    broken = noise.fractal(np.stack([side / 9, y / 14, 0 * x], axis=-1), 2, seed=50 + seed)
    fibre = noise.fractal(np.stack([x / 0.9, y / 16, 0 * x], axis=-1), 3, seed=60 + seed)
    amount = smoothstep(-0.55, 0.6, bands + 0.22 * broken) + 0.10 * fibre
    return MAPLE + (FLAME - MAPLE) * np.clip(amount, 0, 1)[..., None]


def _inlaid(color: np.ndarray, arching: Arching, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """The colour with the purfling, two black strips beside a light one."""
    distance = _edge_distance(arching, x, y)
    away = np.abs(distance - PURFLING)
    blur = 0.25 * LENGTH / len(x)
    strip = smoothstep(LIGHT / 2 + DARK + blur, LIGHT / 2 + DARK - blur, away)[..., None]
    black = smoothstep(LIGHT / 2 - blur, LIGHT / 2 + blur, away)[..., None]
    light = np.array([0.72, 0.53, 0.30])
    return color + (light + (BLACK - light) * black - color) * strip


def _edge_distance(arching: Arching, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Distance from the outline up to 14 mm, of texels."""
    points = np.stack([x, y], axis=-1)
    if x[0, 0] > 0:
        return arching.near_distance(points)
    left = x.shape[1] // 2  # the distance is symmetrical
    distance = arching.near_distance(points[:, left:])
    return np.concatenate([distance[:, ::-1][:, :left], distance], axis=1)


def _depth(
    arching: Arching, x: np.ndarray, y: np.ndarray, worn_at: tuple[float, float]
) -> np.ndarray:
    """Depth of the varnish: worn off at the edge and where hands are, and deep in the channel."""
    distance = _edge_distance(arching, x, y)
    patches = noise.fractal(np.stack([x / 60, y / 75, 0 * x], axis=-1), 4, seed=70)
    fine = noise.fractal(np.stack([x / 9, y / 9, 0 * x], axis=-1), 3, seed=71)
    away = np.hypot(np.abs(x) - worn_at[0], 0.7 * (y - worn_at[1])) / 70
    hand = np.exp(-(away**2)) * smoothstep(-0.5, 0.4, patches + 0.3 * fine)
    edge = np.exp(-(((distance - 1.8) / 1.1) ** 2)) * smoothstep(-0.6, 0.4, fine)
    channel = np.exp(-(((distance - 5.0) / 3.0) ** 2))
    depth = 1.0 + 0.30 * patches + 0.05 * fine + 0.45 * channel - 0.55 * edge - 0.45 * hand
    return np.clip(depth, 0.25, 2.0)
