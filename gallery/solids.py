"""Solid parts of triangle meshes: tubes, lofts, plates cut from flat shapes, holes, and unions."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from gallery.grids import grid
from gallery.mesh import Mesh


def merged(meshes: list[Mesh]) -> Mesh:
    """One mesh of several."""
    first = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    return Mesh(
        np.concatenate([mesh.positions for mesh in meshes]),
        np.concatenate([mesh.normals for mesh in meshes]),
        np.concatenate([mesh.uv for mesh in meshes]),
        np.concatenate([mesh.faces + n for mesh, n in zip(meshes, first, strict=True)]).astype(
            np.int32
        ),
    )


def moved(mesh: Mesh, axes: npt.ArrayLike, origin: npt.ArrayLike = (0, 0, 0)) -> Mesh:
    """The mesh with its x, y and z along the rows of `axes` (3, 3), which are orthogonal.

    Axes of different lengths scale; those of a left-handed frame mirror.
    """
    axes = np.asarray(axes, np.float32)
    normals = mesh.normals @ np.linalg.inv(axes).T
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    faces = mesh.faces if np.linalg.det(axes) > 0 else mesh.faces[:, ::-1]
    positions = mesh.positions @ axes + np.asarray(origin, np.float32)
    return Mesh(positions, normals, mesh.uv, faces)


def in_region(mesh: Mesh, low: tuple[float, float], high: tuple[float, float]) -> Mesh:
    """The mesh with its texture coordinates in the rectangle from `low` to `high`."""
    corner = np.asarray(low, np.float32)
    return replace(mesh, uv=corner + (np.asarray(high, np.float32) - corner) * mesh.uv)


def loft(sections: np.ndarray) -> Mesh:
    """A solid through closed sections (V, U, 3), with flat ends.

    The points of a section go round it, the last repeats the first, and the front is outwards where
    they go anticlockwise seen from the end towards which v grows.
    """
    sides = grid(sections, closed=True)
    return merged([sides, _lid(sections[0, ::-1]), _lid(sections[-1])])


def tube(path: npt.ArrayLike, radius: npt.ArrayLike, sides: int = 12) -> Mesh:
    """A round tube along points (N, 3); radius: one number, or one for each point."""
    path = np.asarray(path, float)
    along = np.gradient(path, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    across = np.cross(along[0], np.eye(3)[np.abs(along[0]).argmin()])
    frames = []
    for direction in along:  # without twist
        across = across - direction * (across @ direction)
        across = across / np.linalg.norm(across)
        frames.append((across, np.cross(direction, across)))
    turn = 2 * np.pi * np.linspace(0, 1, sides + 1)
    turn[-1] = 0
    first, second = (np.array(frames)[:, k, None, :] for k in range(2))
    ring = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
    size = np.broadcast_to(np.asarray(radius, float), len(path))
    return loft(path[:, None] + size[:, None, None] * ring)


def cut(mesh: Mesh, inside: np.ndarray) -> tuple[Mesh, np.ndarray]:
    """The part of a mesh where a function is positive, cut along its linear zeros.

    Args:
        inside: (N,) values of the function at the vertices.

    Returns:
        The mesh, and the cut as pairs of vertex numbers (K, 2), with the mesh on their left.
    """
    inside = np.where(inside == 0, 1e-9, inside)
    sign = inside > 0
    count = sign[mesh.faces].sum(axis=1)
    whole = mesh.faces[count == 3]
    # Turn the triangles so that the corner with the other sign comes first.
    single, double = (mesh.faces[count == k] for k in (1, 2))
    single = _turned(single, sign[single].argmax(axis=1))
    double = _turned(double, sign[double].argmin(axis=1))
    edges = np.concatenate([single[:, [0, 1]], single[:, [0, 2]], double[:, :2], double[:, [0, 2]]])
    low, high = edges.min(axis=1), edges.max(axis=1)
    pairs, numbers = np.unique(np.stack([low, high], axis=1), axis=0, return_inverse=True)
    numbers = numbers.reshape(-1) + len(mesh.positions)
    one, other = inside[pairs[:, 0]], inside[pairs[:, 1]]
    part = (one / (one - other))[:, None]

    def extended(values: np.ndarray) -> np.ndarray:
        new = values[pairs[:, 0]] + part * (values[pairs[:, 1]] - values[pairs[:, 0]])
        return np.concatenate([values, new]).astype(np.float32)

    normals = extended(mesh.normals)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    a, b = np.split(numbers[: 2 * len(single)], 2)
    c, d = np.split(numbers[2 * len(single) :], 2)
    faces = np.concatenate(
        [
            whole,
            np.stack([single[:, 0], a, b], axis=1),
            np.stack([c, double[:, 1], double[:, 2]], axis=1),
            np.stack([c, double[:, 2], d], axis=1),
        ]
    )
    line = np.concatenate([np.stack([a, b], axis=1), np.stack([d, c], axis=1)])
    used, faces_and_line = np.unique(
        np.concatenate([faces.ravel(), line.ravel()]), return_inverse=True
    )
    faces, line = np.split(faces_and_line.reshape(-1), [faces.size])
    result = Mesh(
        extended(mesh.positions)[used],
        normals[used],
        extended(mesh.uv)[used],
        faces.reshape(-1, 3).astype(np.int32),
    )
    return result, line.reshape(-1, 2)


def wall(mesh: Mesh, line: np.ndarray, offset: npt.ArrayLike) -> Mesh:
    """The wall from a cut of the mesh, see `cut`, to its copy moved by `offset` behind the front.

    offset: (3,), or (N, 3) for every vertex of the mesh.
    """
    a, b = mesh.positions[line[:, 0]], mesh.positions[line[:, 1]]
    down = np.broadcast_to(np.asarray(offset, np.float32), mesh.positions.shape)
    c, d = b + down[line[:, 1]], a + down[line[:, 0]]
    normals = np.cross(b - a, down[line[:, 0]])
    # Smooth along the cut: a vertex has the mean of both walls that meet in it.
    sums = np.zeros_like(mesh.positions)
    np.add.at(sums, line.ravel(), -np.repeat(normals, 2, axis=0))
    sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), 1e-12)
    uv = mesh.uv[line]
    index = np.arange(4 * len(line)).reshape(4, -1)
    faces = np.concatenate([index[[0, 2, 1]].T, index[[0, 3, 2]].T])
    return Mesh(
        np.concatenate([a, b, c, d]),
        np.concatenate([sums[line[:, k]] for k in (0, 1, 1, 0)]),
        np.concatenate([uv[:, k] for k in (0, 1, 1, 0)]),
        faces.astype(np.int32),
    )


def signed_distance(points: np.ndarray, polygon: np.ndarray) -> np.ndarray:
    """Distance from points (..., 2) to a closed polygon (K, 2), negative inside it."""
    closed = np.concatenate([polygon, polygon[:1]])
    x, y = points[..., 0], points[..., 1]
    inside = np.zeros(x.shape, bool)
    for (x0, y0), (x1, y1) in pairwise(closed):
        left = (x1 - x0) * (y - y0) > (y1 - y0) * (x - x0)
        inside ^= ((y >= y0) != (y >= y1)) & (left == (y1 > y0))
    return np.where(inside, -1, 1) * distance_to_line(points, closed)


def distance_to_line(points: np.ndarray, line: np.ndarray) -> np.ndarray:
    """Distance from points (..., 2) to a line of straight pieces through (K, 2) points."""
    x, y = points[..., 0], points[..., 1]
    nearest = np.full(x.shape, np.inf)
    for (x0, y0), (x1, y1) in pairwise(line):
        along_x, along_y = x1 - x0, y1 - y0
        to_x, to_y = x - x0, y - y0
        part = (to_x * along_x + to_y * along_y) / max(along_x**2 + along_y**2, 1e-12)
        part = np.clip(part, 0, 1)
        np.minimum(
            nearest, (to_x - part * along_x) ** 2 + (to_y - part * along_y) ** 2, out=nearest
        )
    return np.sqrt(nearest)


def bezier(control: npt.ArrayLike, count: int) -> np.ndarray:
    """Points (count, 2) on a cubic Bézier curve of 4 control points."""
    t = np.linspace(0, 1, count)[:, None]
    a, b, c, d = np.asarray(control, float)
    return (1 - t) ** 3 * a + 3 * (1 - t) ** 2 * t * b + 3 * (1 - t) * t**2 * c + t**3 * d


def section(
    corners: Sequence[Any] | np.ndarray, y: float, count: int, start: npt.ArrayLike | None = None
) -> np.ndarray:
    """A closed section (U, 3) in the plane y through corners (x, z).

    count: points on each side; they are dense near the corners, so that smooth normals leave the
    sides flat. start: a point before the first corner, where the section closes.
    """
    points = np.array(corners, float) if start is None else np.vstack([start, corners])
    if start is not None:
        points = points[:-1]
    ahead = np.roll(points, -1, axis=0)
    part = np.arange(count) / count
    if count > 1:
        part = np.concatenate([[0, 0.04], np.linspace(0.2, 0.8, max(count - 3, 1)), [0.96]])
    ring = (points[:, None] + part[:, None] * (ahead - points)[:, None]).reshape(-1, 2)
    ring = np.vstack([ring, ring[:1]])
    return np.stack([ring[:, 0], np.full(len(ring), y), ring[:, 1]], axis=-1)


def turned(outline: Sequence[tuple[float, float]]) -> list[tuple[float, float]]:
    """Control points of a `Profile` with rather sharp corners through (radius, height)."""
    low, high = outline[0][1], outline[-1][1]
    points = [(0.0, low), (0.5 * outline[0][0], low)]
    for point in outline:
        points += [point, point]
    return [*points, (0.5 * outline[-1][0], high), (0.0, high)]


def curve(points: np.ndarray, y: npt.ArrayLike) -> np.ndarray:
    """A smooth curve z(y) through points (K, 2): cubic Hermite pieces with mean slopes."""
    slopes = np.gradient(points[:, 1], points[:, 0])
    k = np.clip(np.searchsorted(points[:, 0], y) - 1, 0, len(points) - 2)
    (y0, z0), (y1, z1) = points[k].T, points[k + 1].T
    t, wide = (y - y0) / (y1 - y0), y1 - y0
    return (
        (1 + 2 * t) * (1 - t) ** 2 * z0
        + t * (1 - t) ** 2 * wide * slopes[k]
        + t**2 * (3 - 2 * t) * z1
        - t**2 * (1 - t) * wide * slopes[k + 1]
    )


def _lid(ring: np.ndarray) -> Mesh:
    """A flat lid over a closed ring (U, 3), anticlockwise seen from the front."""
    middle = ring[:-1].mean(axis=0)
    normal = np.cross(ring[:-1] - middle, ring[1:] - middle).sum(axis=0)
    normal /= np.linalg.norm(normal)
    count = len(ring)
    index = np.arange(count - 1)
    faces = np.stack([np.full(count - 1, count), index, index + 1], axis=1)
    return Mesh(
        np.vstack([ring, middle]).astype(np.float32),
        np.broadcast_to(normal, (count + 1, 3)).astype(np.float32),
        np.full((count + 1, 2), 0.5, np.float32),
        faces.astype(np.int32),
    )


def _turned(faces: np.ndarray, first: np.ndarray) -> np.ndarray:
    """Triangles with the same orientation that begin with corner `first`."""
    order = (first[:, None] + np.arange(3)) % 3
    return np.take_along_axis(faces, order, axis=1)
