"""Meshes of implicit surfaces by marching cubes (Lorensen and Cline 1987)."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
from skimage.measure import marching_cubes

from gallery.mesh import Mesh, merged, moved

#: Values (N,) of a field at points (N, 3), see `gallery.implicit`.
Field = Callable[[np.ndarray], np.ndarray]

#: Cells along a side of the blocks in which the surface is first looked for.
BLOCK = 4

#: Greatest slope of a field near its surface.
STEEPEST = 1.3

#: Points that are evaluated at once: those that the processor's cache holds.
PIECE = 16384


def mesh(
    field: Field, low: npt.ArrayLike, high: npt.ArrayLike, spacing: float, *, mirror: bool = False
) -> Mesh:
    """The surface of a field as a mesh.

    Vertices are moved onto the surface and have the field's normals, so that reflections are
    smooth. Texture coordinates are zero.

    Args:
        field: see `Field`.
        low, high: corners of a box that contains the surface.
        spacing: edge of a cell.
        mirror: whether the field is given for y >= 0, where the box begins, and its mirror image
            is added.
    """
    low = np.array(low, np.float32)

    def at(points: np.ndarray) -> np.ndarray:
        points = points.astype(np.float32)
        if mirror:
            points[:, 1] = np.abs(points[:, 1])
        pieces = np.array_split(points, len(points) // PIECE + 1)
        return np.concatenate([field(piece) for piece in pieces])

    values = _lattice(at, low, np.ceil(np.subtract(high, low) / spacing).astype(int) + 1, spacing)
    vertices, faces, *_ = marching_cubes(
        values, 0, gradient_direction="descent", allow_degenerate=False
    )
    points = (low + spacing * vertices).astype(np.float32)
    slopes = gradient(at, points, 0.1 * spacing)
    slopes /= np.maximum((slopes**2).sum(axis=-1, keepdims=True), 0.05)
    for _ in range(2):
        here = at(points)
        there = points - np.clip(slopes * here[:, None], -0.5 * spacing, 0.5 * spacing)
        points = np.where((np.abs(at(there)) < np.abs(here))[:, None], there, points)
    normals = gradient(at, points, 0.1 * spacing)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    uv = np.zeros((len(points), 2), np.float32)
    solid = Mesh(points.astype(np.float32), normals.astype(np.float32), uv, faces.astype(np.int32))
    return merged([solid, moved(solid, np.diag([1, -1, 1]))]) if mirror else solid


def gradient(field: Field, points: np.ndarray, step: float) -> np.ndarray:
    """The gradient (N, 3) by central differences."""
    ways = step * np.eye(3, dtype=np.float32)
    differences = [field(points + way) - field(points - way) for way in ways]
    return np.stack(differences, axis=-1) / (2 * step)


def projected(solid: Mesh, size: float) -> Mesh:
    """The mesh with texture coordinates along the two axes that its triangles face least.

    One repetition of a texture covers `size`. Where the axes change, vertices are doubled: the
    texture must be one without visible seams, as noise is.
    """
    corners = solid.positions[solid.faces]
    facing = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    axis = facing.argmax(axis=-1)
    keys, faces = np.unique(solid.faces + axis[:, None] * len(solid.positions), return_inverse=True)
    vertex, axis = keys % len(solid.positions), keys // len(solid.positions)
    points = solid.positions[vertex]
    along = np.array([[1, 2], [0, 2], [0, 1]])[axis]
    uv = (np.take_along_axis(points, along, axis=1) / size).astype(np.float32)
    return Mesh(points, solid.normals[vertex], uv, faces.reshape(-1, 3).astype(np.int32))


def _lattice(field: Field, low: np.ndarray, counts: np.ndarray, spacing: float) -> np.ndarray:
    """Values at the corners of all cells; far from the surface that of a corner of their block."""
    blocks = (counts - 1) // BLOCK + 1
    first = BLOCK * np.stack(np.indices(blocks), axis=-1).reshape(-1, 3)
    values = field(low + spacing * first).reshape(blocks)
    for axis, count in enumerate(counts):
        values = np.repeat(values, BLOCK, axis).take(range(count), axis)
    near = np.abs(values) < STEEPEST * BLOCK * spacing * np.sqrt(3)
    values[near] = field(low + spacing * np.argwhere(near))
    return values
