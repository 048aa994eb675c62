"""Parts of the gallery's scenes: shapes, patterns and maps."""

import numpy as np
import pytest
from gallery import continents, mesh, noise, shoe_shape, still_life_objects, teapot
from gallery.grids import grid
from gallery.mesh import Profile, surface
from gallery.options import Options
from gallery.relief import normal_map
from tests.oracles.meshes import faces, signed_volume


@pytest.fixture(scope="module")
def mi():
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


@pytest.mark.parametrize("part", shoe_shape.SHAPES)
def test_parts_of_the_shoe_face_outwards(part):
    u, v = np.linspace(0, 1, 193), np.linspace(0, 1, 65)
    shape = grid(shoe_shape.SHAPES[part](u[None], v[:, None]), closed=True)
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


def test_a_normal_map_is_the_slope_of_its_heights():
    """A plane that rises by 0.3 along u and falls by 0.2 along v, on a surface of 2 by 3."""
    u, v = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(16) + 0.5) / 16)
    normal = 2 * normal_map(0.3 * 2 * u - 0.2 * 3 * v, 2, 3)[1:-1, 1:-1] - 1
    expected = np.array([-0.3, 0.2, 1]) / np.linalg.norm([-0.3, 0.2, 1])
    np.testing.assert_allclose(normal, np.broadcast_to(expected, normal.shape), atol=1e-6)


def test_a_bump_is_lit_from_its_side(mi, tmp_path):
    """Mitsuba reads relief in our texture coordinates: a hill's slope to the light is brighter."""
    grid_u, grid_v = np.meshgrid(np.linspace(0, 1, 3), np.linspace(0, 1, 3))
    flat = grid(np.stack([grid_u, grid_v, 0 * grid_u], axis=-1))
    mesh.write_ply(flat, tmp_path / "flat.ply")
    u, v = np.meshgrid((np.arange(64) + 0.5) / 64, (np.arange(64) + 0.5) / 64)
    height = 0.1 * np.exp(-((u - 0.5) ** 2 + (v - 0.5) ** 2) / 0.02)
    normals = normal_map(height, 1, 1)
    camera = mi.ScalarTransform4f().look_at([0.5, 0.5, 4], [0.5, 0.5, 0], [0, 1, 0])

    def seen(towards):
        scene = mi.load_dict(
            {
                "type": "scene",
                "integrator": {"type": "direct"},
                "light": {"type": "directional", "direction": [-x for x in towards]},
                "sensor": {
                    "type": "orthographic",
                    "to_world": camera @ mi.ScalarTransform4f().scale([0.5, 0.5, 1]),
                    "film": {
                        "type": "hdrfilm",
                        "width": 32,
                        "height": 32,
                        "rfilter": {"type": "box"},
                    },
                },
                "flat": {
                    "type": "ply",
                    "filename": str(tmp_path / "flat.ply"),
                    "bsdf": {
                        "type": "normalmap",
                        "normalmap": {"type": "bitmap", "data": mi.TensorXf(normals), "raw": True},
                        "bsdf": {"type": "diffuse"},
                    },
                },
            }
        )
        return mi.render(scene, spp=4).numpy().mean(axis=-1)

    even = seen([0, 0, 1])
    # the camera looks down with y up: +x is to the right of its picture
    right = seen([0.6, 0, 0.8]) - 0.8 * even
    above = seen([0, 0.6, 0.8]) - 0.8 * even
    assert right[:, 16:].mean() > 1e-3 > -1e-3 > right[:, :16].mean()
    assert above[:16].mean() > 1e-3 > -1e-3 > above[16:].mean()


def test_parts_of_the_teapot_face_outwards():
    for name, (shape, texels) in teapot.pieces(Options(detail=0.1)).items():
        assert signed_volume(shape) > 0, name
        area, normals = faces(shape)
        large = np.linalg.norm(area, axis=1) > 1e-9
        assert (area * normals).sum(axis=1)[large].min() > 0, name
        low, high = shape.positions.min(axis=0), shape.positions.max(axis=0)
        assert (texels >= low - 0.02).all() and (texels <= high + 0.02).all()


def test_outlines_and_tubes_join_smoothly():
    """Newell's segments share end points and tangents wherever the pot has no edge."""
    body = teapot.Outline(np.array(teapot.BODY))
    for joint in (0.25, 0.5):
        before, after = body(joint - 1e-9), body(joint + 1e-9)
        np.testing.assert_allclose(before[0], after[0], atol=1e-6)
        np.testing.assert_allclose(before[1], after[1], atol=1e-6)
    handle = teapot.Tube(np.array(teapot.HANDLE))
    u = np.linspace(0, 1, 33)
    np.testing.assert_allclose(handle(u, 0.5 - 1e-9), handle(u, 0.5 + 1e-9), atol=1e-6)
    np.testing.assert_allclose(handle(u, 0.3), handle(1 - u, 0.3) * [1, -1, 1], atol=1e-12)


def test_noise_is_continuous_centred_and_determined_by_its_seed():
    points = np.random.default_rng(0).uniform(-30, 30, (20_000, 3))
    for function in (noise.gradient, noise.fractal):
        values = function(points, seed=1)
        assert abs(values.mean()) < 0.05
        assert 0.1 < values.std() < 0.6
        np.testing.assert_allclose(function(points + 1e-5, seed=1), values, atol=1e-3)
        assert np.abs(function(points, seed=2) - values).mean() > 0.1
    first, second = noise.cells(points)
    assert (first >= 0).all() and (first <= second).all()
    assert first.max() < np.sqrt(3)  # the seed of one's own cell is no farther
