"""Triangle meshes: shapes turned on a lathe, unions, and PLY files."""

import os
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from urushi.files import atomic_write


@dataclass(frozen=True)
class Mesh:
    """Triangles with smooth normals and texture coordinates.

    Attributes:
        positions: (N, 3) float32.
        normals: (N, 3) float32 unit vectors, outwards.
        uv: (N, 2) float32; textures repeat outside [0, 1].
        faces: (M, 3) int32 vertex numbers, anticlockwise seen from outside.
    """

    positions: np.ndarray
    normals: np.ndarray
    uv: np.ndarray
    faces: np.ndarray


def merged(meshes: list[Mesh]) -> Mesh:
    """One mesh of several."""
    first = np.cumsum([0] + [len(mesh.positions) for mesh in meshes[:-1]])
    faces = [mesh.faces + n for mesh, n in zip(meshes, first, strict=True)]
    parts = [[getattr(mesh, name) for mesh in meshes] for name in ("positions", "normals", "uv")]
    positions, normals, uv = map(np.concatenate, parts)
    return Mesh(positions, normals, uv, np.concatenate(faces).astype(np.int32))


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


def write_ply(mesh: Mesh, path: str | os.PathLike) -> None:
    """Write `mesh` as a binary PLY file; no partial file is left.

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


#: Half an outline: points (radius, height) and unit tangents at fractions v of its length, from the
#: axis at the bottom to the axis or an edge at the top.
Outline = Callable[[npt.ArrayLike], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Profile:
    """Half of a turned shape's outline, a uniform cubic B-spline (de Boor 1978).

    Attributes:
        control: (K, 2) control points (radius, height), from the centre of the foot to the centre
            of the top. Mirror images of control points continue the outline, so that the curve
            starts and ends on the axis with a horizontal tangent.
    """

    control: np.ndarray

    def __call__(self, v: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Points and unit tangents at `v` in [0, 1], the fraction of the outline's length.

        Returns:
            Two float64 arrays of v's shape + (2,): (radius, height) and its direction.
        """
        dense = np.linspace(0, len(self.control) - 1, 64 * len(self.control) + 1)
        points, _ = self._spline(dense)
        length = np.append(0, np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1)))
        parameter = np.interp(np.asarray(v) * length[-1], length, dense)
        points, tangents = self._spline(parameter)
        return points, tangents / np.linalg.norm(tangents, axis=-1, keepdims=True)

    @property
    def length(self) -> float:
        """Length of the outline."""
        points, _ = self(np.linspace(0, 1, 2048))
        return float(np.linalg.norm(np.diff(points, axis=0), axis=1).sum())

    def _spline(self, t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Points and derivatives at t in [0, K - 1]."""
        mirror = np.array([-1.0, 1.0])
        control = np.vstack([self.control[1] * mirror, self.control, self.control[-2] * mirror])
        first = np.clip(t.astype(int), 0, len(self.control) - 2)
        s = (t - first)[..., None]
        a, b, c, d = (control[first + k] for k in range(4))
        points = (
            (1 - s) ** 3 * a
            + (3 * s**3 - 6 * s**2 + 4) * b
            + (-3 * s**3 + 3 * s**2 + 3 * s + 1) * c
            + s**3 * d
        ) / 6
        tangents = (
            -((1 - s) ** 2) * a + (3 * s**2 - 4 * s) * b + (-3 * s**2 + 2 * s + 1) * c + s**2 * d
        ) / 2
        # On the axis the spline is exact only to rounding: seal the mesh there.
        points[..., 0] = np.where((t <= 0) | (t >= len(self.control) - 1), 0, points[..., 0])
        return points, tangents


def surface(profile: Outline, u: npt.ArrayLike, v: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Positions and outward unit normals of the turned shape.

    Args:
        u: (...) fraction of a turn about the axis, anticlockwise seen from above.
        v: (...) fraction of the outline's length, from the centre of the foot to that of the top.

    Returns:
        Two float64 arrays (..., 3).
    """
    u, v = np.broadcast_arrays(np.asarray(u, float), np.asarray(v, float))
    turn = 2 * np.pi * (u % 1.0)  # u = 1 closes on u = 0 bit for bit
    (radius, height), (along_r, along_z) = (np.moveaxis(x, -1, 0) for x in profile(v))
    cos, sin = np.cos(turn), np.sin(turn)
    positions = np.stack([radius * cos, radius * sin, height], axis=-1)
    normals = np.stack([along_z * cos, along_z * sin, -along_r], axis=-1)
    return positions, normals


def lathe(profile: Outline, segments: int, rings: int) -> Mesh:
    """Revolve `profile` into a closed mesh of `segments` around the axis and `rings` along it."""
    u, v = np.meshgrid(np.arange(segments + 1) / segments, np.arange(rings + 1) / rings)
    at_pole = (v == 0) | (v == 1)
    positions, normals = surface(profile, u, v)
    normals[at_pole] = np.round(normals[at_pole])  # straight down and up
    # A vertex on the axis belongs to one triangle, and its u is the u of the triangle's middle.
    u = np.clip(u + np.select([v == 0, v == 1], [0.5, -0.5]) / segments, 0, 1)
    uv = np.stack([u, v], axis=-1)

    index = np.arange(u.size).reshape(u.shape)
    low, right = index[:-1, :-1], index[:-1, 1:]
    up, across = index[1:, :-1], index[1:, 1:]
    lower = np.stack([low, right, across], axis=-1)[1:]  # degenerate in the first ring
    upper = np.stack([low, across, up], axis=-1)[:-1]  # and in the last
    faces = np.concatenate([lower.reshape(-1, 3), upper.reshape(-1, 3)])
    return Mesh(
        positions.reshape(-1, 3).astype(np.float32),
        normals.reshape(-1, 3).astype(np.float32),
        uv.reshape(-1, 2).astype(np.float32),
        faces.astype(np.int32),
    )
