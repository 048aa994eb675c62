"""Maki-e, drawn by code: cherry blossoms drifting over a stream, in gold under lacquer.

Every motif is drawn in the metric of the surface, so that the texture does not stretch it. Lengths
are those of the object, which is about one high.
"""

from dataclasses import dataclass

import numpy as np

from gallery.mesh import Profile, surface

#: Lines of the stream: their number, mean height and distance.
STREAM_LINES, STREAM_HEIGHT, STREAM_GAP = 7, 0.20, 0.026


@dataclass(frozen=True)
class Canvas:
    """Texel centres of an (H, W) texture on the surface; row 0 is at v = 0.

    Attributes:
        positions: (H, W, 3) float64.
        u, v: (W,) and (H,) texture coordinates.
        soft: half the width of an edge, about one texel.
    """

    positions: np.ndarray
    u: np.ndarray
    v: np.ndarray
    soft: float


@dataclass(frozen=True)
class Placement:
    """Place of a motif: centre (u, v), radius, and rotation in the tangent plane [rad]."""

    u: float
    v: float
    radius: float
    turn: float


def gold(profile: Profile, height: int = 512, *, seed: int = 5) -> np.ndarray:
    """Draw the pattern: the amount of gold that shows through, by texel.

    Args:
        profile: the turned shape that the texture wraps.
        height: rows of the texture; it has twice as many columns.
        seed: of the scattered blossoms, petals and gold dust.

    Returns:
        (height, 2 * height) float32 in [0, 1]: 0 is plain lacquer, 1 is gold.
    """
    canvas = _canvas(profile, height)
    rng = np.random.default_rng(seed)
    image = _stream(canvas)
    blossoms = _drift(rng)
    for place in blossoms:
        _stamp(canvas, profile, place, _blossom, image)
    for place in _petals(rng, blossoms):
        _stamp(canvas, profile, place, _petal, image)
    np.maximum(image, _dust(canvas, profile, blossoms, rng), out=image)
    np.maximum(image, _rim(canvas), out=image)
    return image.astype(np.float32)


def _canvas(profile: Profile, height: int) -> Canvas:
    u, v = (np.arange(2 * height) + 0.5) / (2 * height), (np.arange(height) + 0.5) / height
    positions, _ = surface(profile, u[None, :], v[:, None])
    return Canvas(positions, u, v, 1.1 * profile.length / height)


def _cover(distance: np.ndarray, soft: float) -> np.ndarray:
    """1 where a signed distance is positive, with a smooth edge of half-width `soft`."""
    t = np.clip(0.5 + 0.5 * distance / soft, 0, 1)
    return t * t * (3 - 2 * t)


def _drift(rng: np.random.Generator) -> list[Placement]:
    """Blossoms along a breeze that climbs around the body and over the lid."""
    places: list[Placement] = []
    while len(places) < 22:
        t = rng.uniform()
        spread = rng.normal(0, 0.055)
        u = 0.12 + 0.66 * t + 0.5 * spread
        v = 0.36 + 0.42 * t**1.3 + spread
        radius = rng.choice([0.06, 0.085, 0.12, 0.14]) * (1 - 0.15 * t)
        free = all(
            np.hypot(_wrap(u - p.u) * 2.8, (v - p.v) * 1.8) > 0.97 * (radius + p.radius)
            for p in places
        )
        if free and 0.28 < v < 0.81:
            places.append(Placement(u, v, radius, rng.uniform(0, 2 * np.pi)))
    return places


def _petals(rng: np.random.Generator, blossoms: list[Placement]) -> list[Placement]:
    """Single petals, blown off the blossoms."""
    return [
        Placement(
            (p.u + rng.normal(0, 0.07)) % 1.0,
            float(np.clip(p.v + rng.normal(-0.03, 0.07), 0.2, 0.9)),
            rng.uniform(0.02, 0.036),
            rng.uniform(0, 2 * np.pi),
        )
        for p in blossoms
        for _ in range(2)
    ]


def _wrap(u: np.ndarray | float) -> np.ndarray | float:
    """Difference of two turns, in [-0.5, 0.5)."""
    return (u + 0.5) % 1.0 - 0.5


def _stamp(canvas: Canvas, profile: Profile, place: Placement, motif, image: np.ndarray) -> None:
    """Draw `motif` over the image, in its local frame on the surface."""
    centre, normal = surface(profile, place.u, place.v)
    turn = 2 * np.pi * place.u
    across = np.array([-np.sin(turn), np.cos(turn), 0.0])
    up = np.cross(normal, across)
    rows, columns = np.nonzero(
        ((canvas.positions - centre) ** 2).sum(-1) < (1.1 * place.radius) ** 2
    )
    offset = canvas.positions[rows, columns] - centre
    angle = np.arctan2(offset @ up, offset @ across) - place.turn
    radius = np.linalg.norm(offset, axis=-1)  # the chord: unrolls the curved surface
    ink, paper = motif(radius / place.radius, angle, canvas.soft / place.radius)
    below = image[rows, columns] * (1 - paper)
    image[rows, columns] = np.maximum(below, ink)


def _blossom(r: np.ndarray, angle: np.ndarray, soft: float) -> tuple[np.ndarray, np.ndarray]:
    """Five notched petals with veins and stamens; returns gold and cover, both in [0, 1]."""
    sector = 2 * np.pi / 5
    a = (angle + sector / 2) % sector - sector / 2  # angle to the middle of the petal
    outline = 0.52 + 0.48 * np.abs(np.cos(2.5 * a)) ** 0.7
    outline -= 0.20 * np.exp(-((a / 0.10) ** 2))
    inside = _cover(outline - r, soft)
    between = _cover((sector / 2 - np.abs(a)) * r - 0.022, soft)  # gaps between petals
    shade = 0.35 + 0.65 * _cover(r - 0.62, 0.35) + 0.2 * np.cos(28 * a) * _cover(r - 0.4, 0.2)
    edge = _cover(0.055 - np.abs(outline - r - 0.05), soft)
    petals = inside * between * np.clip(np.maximum(shade, edge), 0, 1)
    stamen_angle = (angle + sector / 4) % (sector / 2) - sector / 4
    stamens = _cover(0.014 - np.abs(stamen_angle) * r, soft) * (r < 0.42) * (r > 0.1)
    tips = _cover(0.04 - np.hypot(r - 0.42, stamen_angle * 0.42), soft)
    heart = _cover(0.085 - r, soft)
    ink = np.maximum.reduce([petals * (r > 0.13), stamens, tips, heart])
    return ink, _cover(outline + 0.10 - r, soft)


def _petal(r: np.ndarray, angle: np.ndarray, soft: float) -> tuple[np.ndarray, np.ndarray]:
    """One petal, pointed at its base and notched at its tip."""
    x, y = r * np.cos(angle), r * np.sin(angle)
    half = 0.55 * np.sqrt(np.clip(1 - x**2, 0, 1)) * (0.35 + 0.65 * (x + 1) / 2)
    notch = 0.22 * np.exp(-((y / 0.16) ** 2))
    inside = np.minimum(half - np.abs(y), 1 - notch - x)
    ink = _cover(inside, soft) * (0.55 + 0.45 * _cover(0.15 - inside, 0.2))
    return ink, _cover(inside + 0.12, soft)


def _stream(canvas: Canvas) -> np.ndarray:
    """Lines of running water about the foot, thickening and thinning as they turn."""
    height = canvas.positions[..., 2]
    turn = 2 * np.pi * canvas.u[None, :]
    image = np.zeros(height.shape)
    for line in range(STREAM_LINES):
        phase = 0.18 * line
        level = STREAM_HEIGHT + STREAM_GAP * (line - STREAM_LINES / 2)
        crest = 0.045 * np.sin(3 * turn + phase) + 0.016 * np.sin(7 * turn - 1.7 * phase + 1)
        swell = 0.5 + 0.5 * np.sin(2 * turn + 1.3 * line)
        width = 0.0015 + 0.0065 * swell
        ink = _cover(width - np.abs(height - level - crest), canvas.soft)
        np.maximum(image, ink * (0.45 + 0.55 * swell), out=image)
    return image


def _rim(canvas: Canvas) -> np.ndarray:
    """A gold line on either side of the lid's groove."""
    radius = np.hypot(canvas.positions[..., 0], canvas.positions[..., 1])
    height = canvas.positions[..., 2]
    lines = [_cover(0.0045 - np.abs(height - z), canvas.soft) for z in (0.668, 0.712)]
    return np.maximum.reduce(lines) * (radius > 0.4) * 0.9


def _dust(
    canvas: Canvas, profile: Profile, blossoms: list[Placement], rng: np.random.Generator
) -> np.ndarray:
    """Sprinkled gold powder (nashiji), densest among the blossoms."""
    count, reach = 5000, 4
    near = rng.integers(len(blossoms), size=count)
    home = np.array([(p.u, p.v) for p in blossoms])[near]
    u = (home[:, 0] + rng.normal(0, 0.055, count)) % 1.0
    v = np.clip(home[:, 1] + rng.normal(0, 0.06, count).clip(-0.15, 0.12), 0.1, 0.93)
    size = rng.uniform(0.0012, 0.0034, count)
    strength = rng.uniform(0.25, 0.9, count)
    rows = (
        np.floor(v * len(canvas.v)).astype(int)[:, None, None]
        + np.arange(-reach, reach + 1)[:, None]
    )
    columns = np.floor(u * len(canvas.u)).astype(int)[:, None, None] + np.arange(-reach, reach + 1)
    rows = np.clip(rows, 0, len(canvas.v) - 1)
    columns %= len(canvas.u)
    centre, _ = surface(profile, u, v)
    distance = np.linalg.norm(canvas.positions[rows, columns] - centre[:, None, None], axis=-1)
    ink = strength[:, None, None] * _cover(size[:, None, None] - distance, canvas.soft)
    image = np.zeros(canvas.positions.shape[:2])
    np.maximum.at(
        image, (np.broadcast_to(rows, ink.shape), np.broadcast_to(columns, ink.shape)), ink
    )
    return image
