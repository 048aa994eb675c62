"""Areas, normals and volumes of meshes."""

import numpy as np
from gallery.mesh import Mesh


def faces(of: Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Twice the area times the normal of every triangle, and the mean of its vertices' normals."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    return np.cross(b - a, c - a), of.normals[of.faces].mean(axis=1)


def signed_volume(of: Mesh) -> float:
    """Volume enclosed (divergence theorem); negative where triangles face inwards."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6)
