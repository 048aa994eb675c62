"""Triangle meshes of surfaces that are given by points on a grid."""

import numpy as np

from gallery.mesh import Mesh


def grid(positions: np.ndarray, *, closed: bool = False) -> Mesh:
    """The mesh of a surface from its points at regular (u, v).

    Args:
        positions: (V, U, 3) points; u grows along the second axis. Normals are du x dv by finite
            differences and point to the front.
        closed: whether the last column repeats the first; normals are then continuous there.
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
    """Derivatives by u and by v, both in [0, 1], of points (V, U, ...) arranged as for `grid`."""
    rows, columns = positions.shape[:2]
    along_v = np.gradient(positions, axis=0) * (rows - 1)
    along_u = np.gradient(positions, axis=1) * (columns - 1)
    if closed:
        seam = (positions[:, 1] - positions[:, -2]) * (columns - 1) / 2
        along_u[:, 0] = along_u[:, -1] = seam
    return along_u, along_v
