"""Parts of the gallery's scenes: shapes, patterns and maps."""

import numpy as np
import pytest
from gallery import continents, shoe_shape, still_life_objects

from urushi.scenes import mesh
from urushi.scenes.mesh import Profile, surface


def faces(of: mesh.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Twice the area times the normal of every triangle, and the mean of its vertices' normals."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    return np.cross(b - a, c - a), of.normals[of.faces].mean(axis=1)


def signed_volume(of: mesh.Mesh) -> float:
    """Volume enclosed (divergence theorem); negative where triangles face inwards."""
    a, b, c = (of.positions[of.faces[:, k]].astype(float) for k in range(3))
    return float((np.cross(a, b) * c).sum() / 6)


@pytest.mark.parametrize("part", shoe_shape.SHAPES)
def test_parts_of_the_shoe_face_outwards(part):
    u, v = np.linspace(0, 1, 193), np.linspace(0, 1, 65)
    shape = mesh.grid(shoe_shape.SHAPES[part](u[None], v[:, None]), closed=True)
    area, normals = faces(shape)
    size = np.linalg.norm(area, axis=1)
    wrong = (area * normals).sum(axis=1) < 0
    assert size[wrong].sum() < 1e-3 * size.sum()  # a few slivers where the lining is folded
    if part in ("sole", "heel", "collar"):
        assert signed_volume(shape) > 0


def test_places_on_the_map_are_land_or_sea():
    """A dozen points well inland and well at sea."""
    inland = [(20, 0), (-100, 40), (-60, -10), (100, 60), (78, 22), (135, -25), (25, 50), (0, -85)]
    at_sea = [(-30, 0), (-140, 0), (75, -20), (160, 20), (0, -50), (-40, 35), (51, 42), (90, 12)]
    land = continents.land(128)
    longitude, latitude = continents.grid(128)
    for places, expected in ((inland, 1), (at_sea, 0)):
        for x, y in places:
            away = np.hypot((longitude - x) % 360, latitude - y)
            assert land.flat[away.argmin()] == expected, (x, y)
    # 29 % of the Earth are land
    share = (land * np.cos(np.radians(latitude))).sum() / np.cos(np.radians(latitude)).sum()
    assert share == pytest.approx(0.29, abs=0.02)


def test_texels_of_turned_shapes_lie_on_them():
    profile = Profile(np.array([(0, 0), (0.5, 0), (1, 0.5), (0.5, 1), (0, 1)]))
    points = still_life_objects.texels(profile, 8)
    assert points.shape == (8, 16, 3)
    np.testing.assert_allclose(points[2, 5], surface(profile, 5.5 / 16, 2.5 / 8)[0])
