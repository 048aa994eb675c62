"""Implicit surfaces: fillets, solids, and the meshes that surface nets make of them."""

import numpy as np
import pytest
from gallery import implicit
from gallery.implicit import Loft
from gallery.mesh import Mesh
from gallery.surface_nets import mesh, projected

RADII = (0.9, 0.5, 0.7)
BOX = (-1.0, -0.6, -0.8), (1.0, 0.6, 0.8)


def egg(points: np.ndarray) -> np.ndarray:
    return implicit.ellipsoid(points, (0, 0, 0), RADII)


@pytest.fixture(scope="module", params=[False, True], ids=["whole", "mirrored"])
def ellipsoid(request) -> Mesh:
    return mesh(egg, *BOX, 0.05, mirror=request.param)


def corners(of: Mesh) -> np.ndarray:
    return of.positions[of.faces].astype(float)


def volume(of: Mesh) -> float:
    """Volume enclosed (divergence theorem); negative where triangles face inwards."""
    a, b, c = np.moveaxis(corners(of), 1, 0)
    return float((np.cross(a, b) * c).sum() / 6)


def test_vertices_and_normals_are_the_surfaces(ellipsoid):
    """Single precision has errors of 1e-6 in the field and of 1e-3 in its differences."""
    assert np.abs(egg(ellipsoid.positions)).max() < 1e-5
    normals = ellipsoid.positions / np.square(RADII)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    assert np.abs(ellipsoid.normals - normals).max() < 5e-3


def test_a_mesh_is_closed_and_faces_outwards(ellipsoid):
    """The chords of cells of 0.05 leave out less than a percent of the volume."""
    points, number = np.unique(ellipsoid.positions, axis=0, return_inverse=True)
    faces = number[ellipsoid.faces]
    edges = np.concatenate([faces[:, [k, (k + 1) % 3]] for k in range(3)])
    whole = 4 / 3 * np.pi * np.prod(RADII)
    assert 0.99 * whole < volume(ellipsoid) < whole
    back = {tuple(edge) for edge in edges[:, ::-1].tolist()}
    assert back == {tuple(edge) for edge in edges.tolist()}, "each edge has two triangles"
    assert len(points) - len(edges) // 2 + len(faces) == 2, "Euler's formula"


def test_projected_textures_are_not_stretched(ellipsoid):
    """A triangle faces its axis by 1 / sqrt(3) at least, and the texture repeats at `size`."""
    flat = projected(ellipsoid, 0.25)
    np.testing.assert_array_equal(corners(flat), corners(ellipsoid))
    a, b, c = np.moveaxis(corners(flat), 1, 0)
    area = np.linalg.norm(np.cross(b - a, c - a), axis=-1)
    u, v, w = np.moveaxis(flat.uv[flat.faces].astype(float), 1, 0)
    texture = np.abs(np.linalg.det(np.stack([v - u, w - u], axis=-1))) * 0.25**2
    assert (texture <= area * (1 + 1e-4) + 1e-9).all()
    assert (texture >= area / np.sqrt(3) * (1 - 1e-2) - 1e-9).all()


def test_fillets_change_fields_only_near_where_they_meet():
    a, b = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-1, 1, 81))
    joined, both = implicit.union(a, b, 0.3), implicit.common(a, b, 0.3)
    apart = np.abs(a - b) >= 0.3
    np.testing.assert_allclose(joined[apart], np.minimum(a, b)[apart], atol=1e-12)
    np.testing.assert_allclose(both[apart], np.maximum(a, b)[apart], atol=1e-12)
    filled = np.minimum(a, b) - joined
    assert filled.min() >= 0 and filled.max() == pytest.approx(0.3 / 6)


def test_a_loft_of_constant_sections_is_a_superellipse_with_round_ends():
    loft = Loft(
        (1.0, -1.0), 0.1, 0.4, (-0.3, 0.5, 0.5, 0.5, 0.5, 0.5, -0.3), (-0.3, *[0.4] * 5, -0.3)
    )
    t = np.linspace(0.1, 1.4, 20)
    y, z = 0.5 * np.cos(t) ** 0.8, 0.1 + 0.4 * np.sin(t) ** 0.8
    points = np.stack([0 * t, y, z], axis=-1).astype(np.float32)
    assert np.abs(loft(points)).max() < 1e-5
    solid = mesh(loft, (-1.1, -0.6, -0.5), (1.1, 0.6, 0.6), 0.04)
    front, back = loft.ends
    assert front == -back and 0.8 < front < 1.0
    assert solid.positions[:, 0].max() == pytest.approx(front, abs=0.02)  # half a cell
    assert np.abs(solid.normals[solid.positions[:, 0].argmax()] - [1, 0, 0]).max() < 0.1


def test_a_spline_has_its_derivative_and_repeats_straight_lines():
    x = np.linspace(-1, 2, 301)
    value, slope = implicit.spline(x, (-1, 2), np.array([0.3, 0.1, 0.7, 0.2, 0.9]))
    differences = np.gradient(value.astype(float), x)
    np.testing.assert_allclose(slope[1:-1], differences[1:-1], atol=2e-3)
    line, _ = implicit.spline(x, (-1, 2), np.linspace(-1, 2, 5))
    np.testing.assert_allclose(line, x, atol=1e-6)
