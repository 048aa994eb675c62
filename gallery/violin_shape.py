"""The body of a violin: outline, arched plates, f-holes and ribs.

Lengths are millimetres, after Antonio Stradivari's "Messiah" of 1716 as published at
makingtheviolin.com: length 356, width of the bouts 167.5, 108.5 and 208, arching, edges, purfling.
x runs across the body, y from the lower end to the neck, z to the front; the ribs end at z = 0.
"""

import numpy as np

from gallery.grids import grid
from gallery.mesh import Mesh
from gallery.solids import (
    bezier,
    cut,
    distance_to_line,
    merged,
    moved,
    signed_distance,
    wall,
)

LENGTH, WIDTH, RIBS = 356.0, 208.0, 31.0
EDGE = 4.2

#: Spacing of the tables from which heights are interpolated.
STEP = 2.0

#: Half of the outline from the lower end to the neck, as cubic Bézier curves, and how far up the
#: middle the lines of the mesh end that begin on each of them.
LOWER: list[list[tuple[float, float]]] = [
    [(0, 0), (59, 0), (104, 26), (104, 72)],
    [(104, 72), (104, 99), (74, 111), (93.4, 129.5)],
    [(93.4, 129.5), (92.5, 131), (91.7, 132.5), (90.8, 134.2)],
]
UPPER: list[list[tuple[float, float]]] = [
    [(90.8, 134.2), (67, 131.5), (54.3, 156), (54.3, 184)],
    [(54.3, 184), (54.3, 208), (60, 221.5), (75.2, 224.6)],
    [(75.2, 224.6), (76.2, 226.4), (77.1, 228), (78.0, 230)],
    [(78.0, 230), (62.5, 247), (83.75, 262), (83.75, 289)],
    [(83.75, 289), (83.75, 328), (50, 356), (0, 356)],
]
MIDDLE = (42, 78, 129, 132, 184, 223, 228, 287, 322)


def outline(spacing: float = 1.3) -> tuple[np.ndarray, np.ndarray]:
    """The right half of the outline, and where the middle line is met from it.

    spacing: about the distance of the points.

    Returns:
        Points (N, 2) from the lower end to the neck, and points (N, 2) with x = 0.
    """
    points, ends = [np.zeros((1, 2))], [np.array([MIDDLE[0]])]
    for number, control in enumerate(LOWER + UPPER):
        dense = bezier(control, 200)
        length = np.append(0, np.cumsum(np.linalg.norm(np.diff(dense, axis=0), axis=1)))
        count = max(3, round(length[-1] / spacing)) + 1
        at = np.linspace(0, length[-1], count)[1:]
        points.append(np.stack([np.interp(at, length, x) for x in dense.T], axis=1))
        ends.append(np.linspace(MIDDLE[number], MIDDLE[number + 1], count)[1:])
    middle = np.concatenate(ends)
    return np.concatenate(points), np.stack([0 * middle, middle], axis=1)


def both_sides(points: np.ndarray) -> np.ndarray:
    """The closed polygon of a half outline (N, 2) and its mirror image."""
    return np.concatenate([points, points[-2:0:-1] * [-1, 1]])


class Arching:
    """The outside of a plate over its outline: an edge, a channel beside it, and an arch."""

    def __init__(self, height: float):
        """height: of the arch's top above the ribs [mm]."""
        self.height = height
        self._half = outline(2.0)[0]
        self._x = np.arange(0, WIDTH / 2 + 2 * STEP, STEP)
        self._y = np.arange(0, LENGTH + STEP, STEP)
        points = np.stack(np.meshgrid(self._x, self._y), axis=-1)
        smooth = self._smooth_distance(points)
        self._tables = np.stack([smooth, self._arch_at(points, smooth)], axis=-1)

    def __call__(self, points: np.ndarray) -> np.ndarray:
        """Heights above the ribs at points (..., 2) inside the outline."""
        arch = self._interpolated(np.abs(points[..., 0]), points[..., 1])[..., 1]
        return self._edge(self.near_distance(points)) + arch

    def near_distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (..., 2) inside the outline from it, up to about 12 mm."""
        smooth = self._interpolated(np.abs(points[..., 0]), points[..., 1])[..., 0]
        near = smooth < 12
        distance = np.full(smooth.shape, 12.0)
        distance[near] = self.distance(points[near])
        return distance

    def distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (..., 2) from the outline."""
        return distance_to_line(np.abs(points), self._half)

    def _edge(self, distance: np.ndarray) -> np.ndarray:
        """Half round outside, a low bead, and the channel that holds the purfling."""
        radius = EDGE / 2
        d = np.clip(distance, 0, radius)
        bead = radius + np.sqrt(radius**2 - (radius - d) ** 2)
        t = np.clip((distance - radius) / 4.0, 0, 1)
        return bead - 1.1 * t * t * (3 - 2 * t)

    def _arch_at(self, points: np.ndarray, smooth: np.ndarray) -> np.ndarray:
        """The arch at points (V, U, 2), the first of a row in the middle.

        It is an arch along the middle, times a section across. smooth: `_smooth_distance` there.
        """
        y = points[..., 1]
        part = np.clip((smooth - 4.5) / np.maximum(smooth[:, :1] - 4.5, 1.0), 0, 1)
        end = np.clip((np.minimum(y, LENGTH - y) - 4.5) / (LENGTH / 2 - 4.5), 0, 1)
        along = np.sin(np.pi / 2 * np.minimum(end * 1.5, 1)) ** 1.15
        return (self.height - EDGE + 1.1) * along * np.sin(np.pi / 2 * part) ** 1.5

    def _smooth_distance(self, points: np.ndarray) -> np.ndarray:
        """Distance of points (..., 2) from the outline, without creases; zero outside.

        It is pi over the integral of the inverse square distance, see Belyaev, Fayolle and Pasko,
        Signed Lp-distance fields (2013).
        """
        polygon = both_sides(self._half)
        ahead = np.roll(polygon, -1, axis=0)
        middles, lengths = (ahead + polygon) / 2, np.linalg.norm(ahead - polygon, axis=1)
        total = np.zeros(points.shape[:-1])
        for middle, length in zip(middles, lengths, strict=True):
            total += length / np.maximum(((points - middle) ** 2).sum(axis=-1), length**2 / 4)
        return np.where(signed_distance(points, polygon) < 0, np.pi / total, 0)

    def _interpolated(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """The tables (..., 2) at |x| and y, by a quadratic B-spline."""
        i, j = x / STEP, y / STEP
        i0, j0 = np.round(i).astype(int), np.round(j).astype(int)
        total = np.zeros((*x.shape, 2))
        for a in (-1, 0, 1):
            for b in (-1, 0, 1):
                columns = np.minimum(np.abs(i0 + a), len(self._x) - 1)
                rows = np.clip(j0 + b, 0, len(self._y) - 1)
                weight = _quadratic(i - i0 - a) * _quadratic(j - j0 - b)
                total += weight[..., None] * self._tables[rows, columns]
        return total


def _quadratic(t: np.ndarray) -> np.ndarray:
    """The uniform quadratic B-spline."""
    t = np.abs(t)
    return np.where(t < 0.5, 0.75 - t**2, 0.5 * np.clip(1.5 - t, 0, None) ** 2)


def plate(arching: Arching, holes: bool) -> Mesh:
    """A plate with its front towards +z, its edge included.

    Texture coordinates are (0.5 + x / WIDTH, y / LENGTH).
    """
    half = _half_plate(arching)
    if holes:
        half, line = cut(half, np.where(half.positions[:, 2] < 3, 1, f_hole(half.positions[:, :2])))
        half = merged([half, wall(half, line, (0, 0, -3.0))])
    whole = merged([half, moved(half, np.diag([-1, 1, 1]))])
    uv = whole.positions[:, :2] / np.array([WIDTH, LENGTH], np.float32)
    return Mesh(whole.positions, whole.normals, uv + np.array([0.5, 0], np.float32), whole.faces)


def _half_plate(arching: Arching) -> Mesh:
    outer, middle = outline()
    inwards = middle - outer
    length = np.linalg.norm(inwards, axis=1, keepdims=True)
    radius = EDGE / 2
    turns = np.linspace(0, np.pi / 2, 7)
    round_edge = radius * (1 - np.cos(turns))
    near = np.concatenate([round_edge, radius + np.array([0.7, 1.4, 2.2, 3.0, 3.8, 4.8, 6.0])])
    rest = np.linspace(0, 1, 71)[1:]
    rows = []
    for distance in near[:0:-1][7:]:  # the edge's lower half
        points = outer + inwards / length * distance
        d = np.minimum(arching.distance(points), radius)
        low = radius - np.sqrt(np.maximum(radius**2 - (radius - d) ** 2, 0))
        rows.append(np.concatenate([points, low[:, None]], axis=1))
    rows.insert(0, np.concatenate([outer + inwards / length * 6, 0 * length], axis=1))
    top = [outer + inwards / length * distance for distance in near]
    top += [points + (middle - points) * part for points in top[-1:] for part in rest]
    heights = arching(np.array(top))
    heights[0] = radius
    rows += list(np.concatenate([np.array(top), heights[..., None]], axis=-1))
    mesh = grid(np.array(rows))
    on_axis = np.abs(mesh.positions[:, 0]) < 1e-6
    normals = np.where(on_axis[:, None] * np.array([True, False, False]), 0, mesh.normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    return Mesh(mesh.positions, normals, mesh.uv, mesh.faces)


#: The right f-hole: its stem as Bézier curves with half widths at their ends, and its eyes.
STEM = [
    ([(25.2, 196.2), (28.2, 201.6), (33.6, 199.2), (33.8, 190.5)], (0.5, 1.0, 1.7)),
    ([(33.8, 190.5), (34.0, 176), (41.0, 152), (41.4, 138.5)], (1.7, 3.3, 1.9)),
    ([(41.4, 138.5), (41.5, 128.5), (47.5, 126.2), (51.2, 131.2)], (1.9, 1.2, 0.6)),
]
EYES = [((24.4, 193.0), 3.1), ((50.4, 135.6), 4.2)]
NOTCH = np.array([(33.4, 163.4), (37.6, 162.7), (41.9, 163.6), (41.9, 164.4), (33.4, 164.2)])


def f_hole(points: np.ndarray) -> np.ndarray:
    """About the distance from the right f-hole at points (..., 2), negative inside it.

    At points far from it, it is just positive.
    """
    result = np.full(points.shape[:-1], 10.0)
    near = ((points > np.array([18, 124])) & (points < np.array([58, 204]))).all(axis=-1)
    result[near] = _distance_from_hole(points[near])
    return result


def _distance_from_hole(points: np.ndarray) -> np.ndarray:
    result = signed_distance(points, NOTCH)
    for centre, radius in EYES:
        result = np.minimum(result, np.linalg.norm(points - np.array(centre), axis=-1) - radius)
    for control, widths in STEM:
        part = np.linspace(0, 1, 40)
        width = np.interp(part, [0, 0.5, 1], widths)
        for centre, half in zip(bezier(control, 40), width, strict=True):
            result = np.minimum(result, np.linalg.norm(points - centre, axis=-1) - half)
    return result


def ribs() -> Mesh:
    """The sides between the plates; u runs round the body, v across from the back."""
    outer, middle = outline()
    inwards = middle - outer
    line = outer + 3.0 * inwards / np.linalg.norm(inwards, axis=1, keepdims=True)
    heights = np.linspace(-RIBS, 0, 5)[:, None, None]
    rows = np.concatenate(
        [np.broadcast_to(line, (5, *line.shape)), np.broadcast_to(heights, (5, len(line), 1))],
        axis=-1,
    )
    half = grid(rows)
    return merged([half, moved(half, np.diag([-1, 1, 1]))])
