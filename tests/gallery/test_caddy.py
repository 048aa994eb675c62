"""The demo's caddy: its shape, its pattern and its lacquer."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from gallery import caddy, caddy_pattern
from gallery.mesh import Mesh, lathe, write_ply

from urushi.errors import FileError


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return lathe(caddy.natsume(), 48, 96)


def _corners(mesh: Mesh) -> np.ndarray:
    """Faces by position: vertices that lie in one place (the seam, the poles) count as one."""
    _, same = np.unique(mesh.positions, axis=0, return_inverse=True)
    return same.reshape(-1)[mesh.faces]


def test_the_caddy_is_watertight_and_consistently_oriented(mesh):
    """Every directed edge occurs once, and its reverse once."""
    corners = _corners(mesh)
    edges = Counter(
        (int(a), int(b))
        for k in range(3)
        for a, b in zip(corners[:, k], corners[:, (k + 1) % 3], strict=True)
    )
    assert all(a != b for a, b in edges), "a triangle has no area"
    assert set(edges.values()) == {1}
    assert all((b, a) in edges for a, b in edges)
    vertices = len(np.unique(mesh.positions, axis=0))
    assert vertices - len(edges) // 2 + len(corners) == 2, "Euler's number of a sphere"


def test_the_caddy_is_oriented_outwards(mesh):
    """Its signed volume (divergence theorem) is positive and close to that of the profile."""
    a, b, c = (mesh.positions[mesh.faces[:, k]].astype(float) for k in range(3))
    volume = (np.cross(a, b) * c).sum() / 6
    points, _ = caddy.natsume()(np.linspace(0, 1, 4000))
    turned = np.pi * np.trapezoid(points[:, 0] ** 2, points[:, 1])
    # A 48-gon has (sin x) / x = 0.9971 of its circle's area, x = 2 pi / 48.
    assert volume == pytest.approx(turned * 0.9971, rel=2e-3)


def test_normals_are_unit_and_agree_with_the_triangles(mesh):
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-6)
    a, b, c = (mesh.positions[mesh.faces[:, k]].astype(float) for k in range(3))
    flat = np.cross(b - a, c - a)
    flat /= np.linalg.norm(flat, axis=1, keepdims=True)
    cosines = [(flat * mesh.normals[mesh.faces[:, k]]).sum(1) for k in range(3)]
    assert np.min(cosines) > 0.5  # the groove of the lid turns within a few triangles
    assert np.median(cosines) > 0.995


def test_texture_coordinates_cover_the_unit_square(mesh):
    assert mesh.uv.min() == 0 and mesh.uv.max() == 1
    spread = np.ptp(mesh.uv[mesh.faces][..., 0], axis=1)
    assert spread.max() < 1.01 / 48, "no triangle crosses the seam"


def test_the_profile_is_parametrised_by_its_length():
    points, tangents = caddy.natsume()(np.linspace(0, 1, 4001))
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    assert np.ptp(steps) < 0.05 * steps.mean()
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1, atol=1e-12)
    assert points[0, 0] == points[-1, 0] == 0


def test_ply_holds_the_mesh(mesh, tmp_path):
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    write_ply(mesh, tmp_path / "caddy.ply")
    loaded = mi.load_dict({"type": "ply", "filename": str(tmp_path / "caddy.ply")})
    parameters = mi.traverse(loaded)
    for name, ours in (
        ("vertex_positions", mesh.positions),
        ("vertex_normals", mesh.normals),
        ("vertex_texcoords", mesh.uv),
        ("faces", mesh.faces),
    ):
        stored = np.array(parameters[name]).reshape(ours.shape)
        np.testing.assert_allclose(stored, ours, atol=2e-7)  # Mitsuba normalises normals again


def test_the_pattern_is_deterministic_and_in_range():
    first = caddy_pattern.gold(caddy.natsume(), 64)
    assert first.shape == (64, 128) and first.dtype == np.float32
    assert first.min() == 0 and 0.7 < first.max() <= 1
    np.testing.assert_array_equal(first, caddy_pattern.gold(caddy.natsume(), 64))
    assert (first != caddy_pattern.gold(caddy.natsume(), 64, seed=9)).any()


def test_the_pattern_closes_around_the_caddy():
    """Columns on both sides of the seam differ no more than other neighbours do."""
    image = caddy_pattern.gold(caddy.natsume(), 128)
    steps = np.abs(np.diff(image, axis=1)).mean(axis=0)
    assert np.abs(image[:, 0] - image[:, -1]).mean() <= steps.max()


def test_the_lacquer_is_a_valid_coat():
    depth, albedo = caddy.lacquer(96)
    assert depth.shape == albedo.shape == (96, 192, 3)
    assert depth.min() > 0 and depth.max() <= 8, "within what the networks are trained on"
    assert albedo.min() >= 0 and albedo.max() <= 1


def test_unwritable_meshes_are_one_sentence():
    with pytest.raises(FileError, match=r"^cannot write .*; choose a folder that exists"):
        write_ply(lathe(caddy.natsume(), 4, 8), Path("/proc/caddy.ply"))
