"""Triangle meshes: their arrays, surfaces given on a grid, and PLY files."""

import os
from dataclasses import dataclass

import numpy as np

from urushi.files import atomic_write


@dataclass(frozen=True)
class Mesh:
    """Triangles with smooth normals and texture coordinates.

    Attributes:
        positions: (N, 3) float32.
        normals: (N, 3) float32 unit vectors, outwards.
        uv: (N, 2) float32 in [0, 1].
        faces: (M, 3) int32 vertex numbers, anticlockwise seen from outside.
    """

    positions: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    faces: np.ndarray


def grid(positions: np.ndarray, *, closed: bool = False) -> Mesh:
    """A surface given by its points at regular (u, v).

    Args:
        positions: (V, U, 3) points; u grows along the second axis. Normals are du x dv, by
            differences; the front is where they point.
        closed: the last column repeats the first, and normals are continuous there.
    """
    along_u, along_v = derivatives(positions, closed=closed)
    normals = np.cross(along_u, along_v)
    normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-12)
    rows, columns = positions.shape[:2]
    u, v = np.meshgrid(np.linspace(0, 1, columns), np.linspace(0, 1, rows))
    index = np.arange(rows * columns).reshape(rows, columns)
    low, right = index[:-1, :-1].ravel(), index[:-1, 1:].ravel()
    up, across = index[1:, :-1].ravel(), index[1:, 1:].ravel()
    faces = np.stack([low, right, across, low, across, up], axis=-1).reshape(-1, 3)
    return Mesh(
        positions.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        np.stack([u, v], axis=-1).reshape(-1, 2).astype(np.float32),
        faces.astype(np.int32),
    )


def derivatives(positions: np.ndarray, *, closed: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Derivatives by u and by v, both in [0, 1], of points (V, U, ...) as of `grid`."""
    rows, columns = positions.shape[:2]
    along_v = np.gradient(positions, axis=0) * (rows - 1)
    along_u = np.gradient(positions, axis=1) * (columns - 1)
    if closed:
        seam = (positions[:, 1] - positions[:, -2]) * (columns - 1) / 2
        along_u[:, 0] = along_u[:, -1] = seam
    return along_u, along_v


def write_ply(mesh: Mesh, path: str | os.PathLike) -> None:
    """Write `mesh` as a binary PLY file, whole or not at all.

    Raises:
        FileError: the folder is missing or cannot be written.
    """
    fields = ("x", "y", "z", "nx", "ny", "nz", "u", "v")
    header = "\n".join(
        ["ply", "format binary_little_endian 1.0", f"element vertex {len(mesh.positions)}"]
        + [f"property float {name}" for name in fields]
        + [f"element face {len(mesh.faces)}", "property list uchar int vertex_index", "end_header"]
    )
    vertices = np.hstack([mesh.positions, mesh.normals, mesh.uv]).astype("<f4")
    faces = np.empty(len(mesh.faces), dtype=[("count", "u1"), ("vertex", "<i4", 3)])
    faces["count"], faces["vertex"] = 3, mesh.faces
    with atomic_write(path) as temporary:
        temporary.write_bytes(header.encode() + b"\n" + vertices.tobytes() + faces.tobytes())
