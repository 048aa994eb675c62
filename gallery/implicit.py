"""Implicit solids: fields of simple shapes, joined and cut with fillets.

A field is negative inside, and close to the distance from its surface near it. Points are (N, 3),
or their coordinates (N,).
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt


def union(a: np.ndarray, b: npt.ArrayLike, radius: float) -> np.ndarray:
    """Smaller of two fields' values, with a fillet of about `radius`; curvature is continuous.

    Source: the cubic smooth minimum of Quilez 2013.
    """
    near = np.maximum(radius - np.abs(a - b), 0) / radius
    return np.minimum(a, b) - near**3 * (radius / 6)


def common(a: np.ndarray, b: npt.ArrayLike, radius: float) -> np.ndarray:
    """Greater of two fields' values, that of what both contain, with edges rounded by `radius`."""
    return -union(-a, np.negative(b), radius)


def tube(a: np.ndarray, b: np.ndarray, radius: float) -> np.ndarray:
    """A round wire along the curve in which two surfaces meet."""
    return np.hypot(a, b) - radius


def ellipsoid(points: np.ndarray, centre: npt.ArrayLike, radii: npt.ArrayLike) -> np.ndarray:
    """The field of an ellipsoid."""
    scale = 1 / np.asarray(radii, np.float32)
    local = (points - np.asarray(centre, np.float32)) * scale
    reach = np.sqrt(np.maximum((local * local).sum(axis=-1), 1e-12))
    slope = np.linalg.norm(local * scale, axis=-1)
    return (reach - 1) * reach / np.maximum(slope, 1e-6)


def superellipsoid(points: np.ndarray, centre: npt.ArrayLike, radii: npt.ArrayLike) -> np.ndarray:
    """The field of |x / rx|^2.5 + |y / ry|^2.5 + |z / rz|^2.5 = 1."""
    scale = 1 / np.asarray(radii, np.float32)
    local = np.abs(points - np.asarray(centre, np.float32)) * scale
    powers = local * np.sqrt(local)
    total = np.maximum((powers * local).sum(axis=-1), 1e-12)
    reach = total**0.4
    slope = np.linalg.norm(powers * scale, axis=-1) * reach / total
    return (reach - 1) / np.maximum(slope, 1e-6)


def segment(points: np.ndarray, start: npt.ArrayLike, end: npt.ArrayLike) -> np.ndarray:
    """Distance of points (N, K) from a straight line's part between two points (K,)."""
    along = np.subtract(end, start).astype(np.float32)
    there = points - np.asarray(start, np.float32)
    share = np.clip(there @ along / (along @ along), 0, 1)
    return np.linalg.norm(there - share[:, None] * along, axis=-1)


def polygon(a: np.ndarray, b: np.ndarray, corners: npt.ArrayLike, radius: float) -> np.ndarray:
    """A convex polygon, its corners (K, 2) anticlockwise, rounded by `radius`."""
    corners = np.asarray(corners, np.float32)
    result = None
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = (end - start) / np.linalg.norm(end - start)
        side = (a - start[0]) * along[1] - (b - start[1]) * along[0]
        result = side if result is None else common(result, side, radius)
    assert result is not None
    return result


@dataclass(frozen=True)
class Loft:
    """A solid along x whose sections are superellipses |y / w|^2.5 + |z / h|^2.5 = 1.

    Attributes:
        span: where the splines of w and h start and end. The solid ends where they are zero.
        middle: z of the sections' widest place.
        below: h under the middle, where the solid is wide.
        width, height: w, and h above the middle, at equal steps over the span. Their squares, which
            keep the sign, are the control values of uniform cubic B-splines: ends are round.
    """

    span: tuple[float, float]
    middle: float
    below: float
    width: tuple[float, ...]
    height: tuple[float, ...]

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """The field at points (N, 3)."""
        x, y, z = points.T
        front, back = self.ends
        beyond = np.maximum(np.maximum(x - front, back - x), 0)
        (w2, dw2), (h2, dh2) = self._squares(np.clip(x, back, front))
        w2, h2 = np.maximum(w2, 1e-6), np.maximum(h2, 1e-6)
        z = z - np.float32(self.middle)
        under = z < 0
        h2 = np.where(under, self.below**2 * w2 / (w2 + 0.02), h2)
        dh2 = np.where(under, 0, dh2)
        y2, z2 = y * y + 1e-9, z * z + 1e-9
        a, b = (t * np.sqrt(np.sqrt(t)) for t in (y2 / w2, z2 / h2))
        total = a + b
        r2 = y2 + z2
        edge2 = r2 * total**-0.8  # squared radius of the section in the direction of the point
        # The slope of r2 - edge2 on the surface, across and along the loft.
        across = np.sqrt(a * a / y2 + b * b / z2) * (np.sqrt(r2) / total)
        across = across * (np.sqrt(r2) + np.sqrt(edge2))
        along = edge2 * (a * dw2 / w2 + b * dh2 / h2) / total
        distance = (r2 - edge2) / np.sqrt(across * across + along * along)
        return np.where(beyond > 0, np.hypot(np.maximum(distance, 0), beyond), distance)

    @cached_property
    def ends(self) -> tuple[float, float]:
        """x of the two ends."""
        x = np.linspace(*self.span, 512)
        solid = x[np.minimum(*(value for value, _ in self._squares(x))) > 1e-4]
        return float(solid[0]), float(solid[-1])

    def _squares(self, x: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """Squares of w and h, and their derivatives."""
        return [
            spline(x, self.span, np.sign(values) * np.square(values))
            for values in (self.width, self.height)
        ]


def spline(
    x: np.ndarray, span: tuple[float, float], control: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """A uniform cubic B-spline over a span of x, straight at its ends, and its derivative."""
    values = np.concatenate(
        [[2 * control[0] - control[1]], control, [2 * control[-1] - control[-2]]]
    ).astype(np.float32)
    scale = (len(control) - 1) / (span[1] - span[0])
    t = np.clip((x - span[0]) * scale, 0, len(control) - 1)
    first = np.minimum(t.astype(int), len(control) - 2)
    s = t - first
    a, b, c, d = (values[first + k] for k in range(4))
    value = (
        (1 - s) ** 3 * a
        + (3 * s**3 - 6 * s**2 + 4) * b
        + (-3 * s**3 + 3 * s**2 + 3 * s + 1) * c
        + s**3 * d
    ) / 6
    slope = (
        -((1 - s) ** 2) * a + (3 * s**2 - 4 * s) * b + (-3 * s**2 + 2 * s + 1) * c + s**2 * d
    ) / 2
    return value, slope * scale
