"""Meshes of implicit surfaces by surface nets (Gibson 1998)."""

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from gallery.mesh import Mesh

#: Values (N,) of a field at points (N, 3), see `gallery.implicit`.
Field = Callable[[np.ndarray], np.ndarray]

#: Cells along a side of the blocks in which the surface is first looked for.
BLOCK = 4

#: Greatest slope of a field near its surface.
STEEPEST = 1.3

#: Points that are evaluated at once: those that the processor's cache holds.
PIECE = 16384


def gradient(field: Field, points: np.ndarray, step: float) -> np.ndarray:
    """The gradient (N, 3) by central differences."""
    ways = step * np.eye(3, dtype=np.float32)
    return np.stack([field(points + way) - field(points - way) for way in ways], axis=-1) / (
        2 * step
    )


def mesh(
    field: Field, low: npt.ArrayLike, high: npt.ArrayLike, spacing: float, *, mirror: bool = False
) -> Mesh:
    """The surface of a field as a mesh, by surface nets.

    Vertices are moved onto the surface and have the field's normals, so that reflections are
    smooth. Texture coordinates are zero.

    Args:
        field: see `Field`.
        low, high: corners of a box that contains the surface.
        spacing: edge of a cell.
        mirror: whether the field is given for y >= 0 and its mirror image is added.
    """
    field = _in_pieces(field)
    low = np.array(low, np.float32)
    if mirror:
        low[1] = -0.5 * spacing  # the first cells lie astride the mirror
    blocks = np.ceil(np.subtract(high, low) / (spacing * BLOCK)).astype(int)
    lattice = _near(field, low, blocks, spacing)
    cells = _crossed(lattice)
    number = np.full(lattice.shape, -1)
    number[tuple(cells.T)] = np.arange(len(cells))
    points = (low + spacing * (cells + _centres(lattice, cells))).astype(np.float32)
    slopes = gradient(field, points, 0.1 * spacing)
    slopes /= np.maximum((slopes**2).sum(axis=-1, keepdims=True), 0.05)
    values = field(points)
    for _ in range(2):
        step = np.clip(slopes * values[:, None], -0.5 * spacing, 0.5 * spacing)
        moved = field(points - step)
        closer = np.abs(moved) < np.abs(values)
        points = np.where(closer[:, None], points - step, points)
        values = np.where(closer, moved, values)
    normals = gradient(field, points, 0.1 * spacing)
    if mirror:
        points[cells[:, 1] == 0, 1] = normals[cells[:, 1] == 0, 1] = 0
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    result = Mesh(
        points.astype(np.float32),
        normals.astype(np.float32),
        np.zeros((len(points), 2), np.float32),
        _faces(lattice, number).astype(np.int32),
    )
    return _with_mirror_image(result) if mirror else result


def _with_mirror_image(half: Mesh) -> Mesh:
    """The mesh and its mirror image in y."""
    flip = np.array([1, -1, 1], np.float32)
    return Mesh(
        np.concatenate([half.positions, half.positions * flip]),
        np.concatenate([half.normals, half.normals * flip]),
        np.concatenate([half.uv, half.uv]),
        np.concatenate([half.faces, half.faces[:, ::-1] + len(half.positions)]),
    )


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
    uv = np.take_along_axis(points, along, axis=1) / size
    return Mesh(
        points,
        solid.normals[vertex],
        uv.astype(np.float32),
        faces.reshape(-1, 3).astype(np.int32),
    )


def _in_pieces(field: Field) -> Field:
    """The field, evaluated for as many points at once as stay in the processor's cache."""

    def evaluate(points: np.ndarray) -> np.ndarray:
        pieces = np.array_split(points.astype(np.float32), len(points) // PIECE + 1)
        return np.concatenate([field(piece) for piece in pieces])

    return evaluate


def _near(field: Field, low: np.ndarray, blocks: np.ndarray, spacing: float) -> np.ndarray:
    """Values at the corners of all cells; far from the surface, some of the right sign."""
    size = spacing * BLOCK
    index = np.stack(np.meshgrid(*map(np.arange, blocks), indexing="ij"), axis=-1).reshape(-1, 3)
    middle = field(low + size * (index + 0.5))
    reach = STEEPEST * size * np.sqrt(3) / 2
    shape = tuple(blocks * BLOCK + 1)
    inside = np.repeat(
        np.repeat(np.repeat((middle < 0).reshape(blocks), BLOCK, 0), BLOCK, 1), BLOCK, 2
    )
    values = np.full(shape, reach, np.float32)
    values[:-1, :-1, :-1] = np.where(inside, -reach, reach)
    known = np.zeros(shape, bool)
    offsets = np.stack(np.meshgrid(*[np.arange(BLOCK + 1)] * 3, indexing="ij"), axis=-1)
    near = index[np.abs(middle) < reach]
    corner = near[:, None, None, None] * BLOCK + offsets
    known[tuple(np.moveaxis(corner, -1, 0))] = True
    at = np.argwhere(known)
    values[known] = field(low + spacing * at)
    return values


def _crossed(values: np.ndarray) -> np.ndarray:
    """Indices (N, 3) of the cells that the surface crosses."""
    inside = values < 0
    count = np.zeros(np.subtract(values.shape, 1), np.int8)
    for shift in np.ndindex(2, 2, 2):
        count += inside[tuple(slice(s, s - 1 or None) for s in shift)]
    return np.argwhere((count > 0) & (count < 8))


def _centres(values: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """Mean of the points (N, 3) in [0, 1] where the surface crosses a cell's edges."""
    total, count = np.zeros((len(cells), 3)), np.zeros(len(cells))
    for axis in range(3):
        for a, b in np.ndindex(2, 2):
            start = np.insert([a, b], axis, 0)
            end = np.insert([a, b], axis, 1)
            first, second = (values[tuple((cells + corner).T)] for corner in (start, end))
            crosses = (first < 0) != (second < 0)
            at = np.where(crosses, first / np.where(crosses, first - second, 1), 0)
            total += crosses[:, None] * (start + at[:, None] * (end - start))
            count += crosses
    return total / count[:, None]


def _faces(values: np.ndarray, number: np.ndarray) -> np.ndarray:
    """Triangles (M, 3): two for each edge of the grid that the surface crosses inside the box."""
    faces = []
    for axis in range(3):
        first = np.moveaxis(values, axis, 0)
        cell = np.moveaxis(number, axis, 0)
        start, end = first[:-1, 1:-1, 1:-1] < 0, first[1:, 1:-1, 1:-1] < 0
        i, j, k = np.nonzero(start != end)
        around = [cell[i, j + a, k + b] for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))]
        quads = np.stack(around, axis=-1)
        # The other two axes are in cyclic order for x and z alone.
        turned = start[i, j, k] != (axis == 1)
        quads[~turned] = quads[~turned, ::-1]
        faces += [quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]
    return np.concatenate(faces)
