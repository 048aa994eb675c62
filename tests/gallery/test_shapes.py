"""Meshes, implicit surfaces and patterns of the gallery's scenes."""

from collections import Counter

import mitsuba as mi
import numpy as np
import pytest
from gallery import caddy, car, car_shape, globe, implicit, noise, shoe_shape, stage, teapot
from gallery.grids import grid
from gallery.implicit import Loft
from gallery.isosurface import mesh, projected
from gallery.mesh import Mesh, lathe
from gallery.options import Options
from gallery.relief import normal_map
from tests.oracles.meshes import faces, signed_volume

RADII = (0.9, 0.5, 0.7)


def egg(points: np.ndarray) -> np.ndarray:
    return implicit.ellipsoid(points, (0, 0, 0), RADII)


@pytest.fixture(scope="module", params=["whole", "mirrored"])
def ellipsoid(request) -> Mesh:
    low = (-1.0, 0 if request.param == "mirrored" else -0.6, -0.8)
    return mesh(egg, low, (1.0, 0.6, 0.8), 0.05, mirror=request.param == "mirrored")


def check_closed(of: Mesh) -> None:
    """Every directed edge occurs once, and its reverse once; Euler's number is that of a sphere."""
    points, number = np.unique(of.positions, axis=0, return_inverse=True)
    triangles = number.reshape(-1)[of.faces]
    edges = Counter(
        edge for k in range(3) for edge in map(tuple, triangles[:, [k, (k + 1) % 3]].tolist())
    )
    assert set(edges.values()) == {1} and all((b, a) in edges for a, b in edges)
    assert len(points) - len(edges) // 2 + len(triangles) == 2


def check_outwards(of: Mesh, share: float) -> None:
    """Triangles face as their normals do, but for slivers of this share of the area."""
    area, normals = faces(of)
    size = np.linalg.norm(area, axis=1)
    assert size[(area * normals).sum(axis=1) < 0].sum() <= share * size.sum()


def test_a_turned_shape_is_closed_and_has_the_volume_of_its_outline():
    turned = lathe(caddy.natsume(), 48, 96)
    check_closed(turned)
    check_outwards(turned, 0)
    points, _ = caddy.natsume()(np.linspace(0, 1, 4000))
    volume = np.pi * np.trapezoid(points[:, 0] ** 2, points[:, 1])
    # A 48-gon has (sin x) / x = 0.9971 of its circle's area, x = 2 pi / 48.
    assert signed_volume(turned) == pytest.approx(volume * 0.9971, rel=2e-3)
    assert turned.uv.min() == 0 and turned.uv.max() == 1
    assert np.ptp(turned.uv[turned.faces][..., 0], axis=1).max() < 1.01 / 48


def test_meshes_of_fields_are_closed_and_lie_on_the_surface(ellipsoid):
    """Chords of cells of 0.05 leave out less than a percent of the volume."""
    check_closed(ellipsoid)
    whole = 4 / 3 * np.pi * np.prod(RADII)
    assert 0.99 * whole < signed_volume(ellipsoid) < whole
    # Single precision has errors of 1e-6 in the field and of 1e-3 in its differences.
    assert np.abs(egg(ellipsoid.positions)).max() < 1e-5
    normals = ellipsoid.positions / np.square(RADII)
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    assert np.abs(ellipsoid.normals - normals).max() < 5e-3


def test_projected_textures_are_not_stretched(ellipsoid):
    """A triangle faces its axis by 1 / sqrt(3) at least, and the texture repeats at the size."""
    flat = projected(ellipsoid, 0.25)
    np.testing.assert_array_equal(flat.positions[flat.faces], ellipsoid.positions[ellipsoid.faces])
    area = np.linalg.norm(faces(flat)[0], axis=-1)
    u, v, w = np.moveaxis(flat.uv[flat.faces].astype(float), 1, 0)
    texture = np.abs(np.linalg.det(np.stack([v - u, w - u], axis=-1))) * 0.25**2
    assert (texture <= area * (1 + 1e-4) + 1e-9).all()
    assert (texture >= area / np.sqrt(3) * (1 - 1e-2) - 1e-9).all()


def test_fillets_change_fields_only_near_where_they_meet():
    a, b = np.meshgrid(np.linspace(-1, 1, 81), np.linspace(-1, 1, 81))
    joined, apart = implicit.union(a, b, 0.3), np.abs(a - b) >= 0.3
    np.testing.assert_allclose(joined[apart], np.minimum(a, b)[apart], atol=1e-12)
    filled = np.minimum(a, b) - joined
    assert filled.min() >= 0 and filled.max() == pytest.approx(0.3 / 6)


def test_a_loft_of_constant_sections_is_a_superellipse_with_round_ends():
    loft = Loft((1, -1), 0.1, 0.4, (-0.3, *[0.5] * 5, -0.3), (-0.3, *[0.4] * 5, -0.3))
    t = np.linspace(0.1, 1.4, 20)
    points = np.stack([0 * t, 0.5 * np.cos(t) ** 0.8, 0.1 + 0.4 * np.sin(t) ** 0.8], axis=-1)
    assert np.abs(loft(points.astype(np.float32))).max() < 1e-5
    solid = mesh(loft, (-1.1, -0.6, -0.5), (1.1, 0.6, 0.6), 0.04)
    front, back = loft.ends
    assert front == -back and 0.8 < front < 1.0
    assert solid.positions[:, 0].max() == pytest.approx(front, abs=0.02)  # half a cell


def test_the_car_stands_on_its_tyres_and_is_symmetric():
    parts = car.meshes()
    lowest = {name: float(part.positions[:, 2].min()) for name, part in parts.items()}
    assert min(lowest, key=lowest.get) == "tyres" and abs(lowest["tyres"]) < 0.005
    low, high = np.array(car.BODY, float)
    for name, part in parts.items():
        check_outwards(part, 0.01)  # cells are too coarse for some folds and edges
        assert signed_volume(part) > 0, name
        y = part.positions[:, 1]
        assert y.min() == pytest.approx(-y.max(), abs=1e-3), name
        if name in ("body", "panes", "boards"):  # not cut off by the box
            assert (part.positions.min(axis=0)[[0, 2]] > low[[0, 2]] + car.FINE).all(), name
            assert (part.positions.max(axis=0) < high - car.FINE).all(), name
    assert car_shape.skin(parts["panes"].positions).max() < -0.01


def test_parts_of_the_shoe_and_of_the_teapot_face_outwards():
    u, v = np.linspace(0, 1, 193), np.linspace(0, 1, 65)
    for shape in shoe_shape.SHAPES.values():
        check_outwards(grid(shape(u[None], v[:, None]), closed=True), 1e-3)
    for shape, texels in teapot.pieces(Options(detail=0.1)).values():
        check_outwards(shape, 0)
        low, high = shape.positions.min(axis=0), shape.positions.max(axis=0)
        assert (texels >= low - 0.02).all() and (texels <= high + 0.02).all()


def test_flakes_repeat_without_a_seam():
    number = car.flakes(120, 15, np.random.default_rng(3))
    assert len(np.unique(number)) > 0.95 * 15**2
    inside, across = (number[1:] == number[:-1]).mean(), (number[0] == number[-1]).mean()
    assert across == pytest.approx(inside, abs=0.1)


def test_the_maps_of_scenes_are_coats():
    """Of any size; less than a third of the Earth is land, where the medium is thin."""
    mi.set_variant("scalar_rgb")
    for rows in (26, 512):
        albedo, depth = globe.chart(rows)
        assert albedo.shape == depth.shape == (rows, 2 * rows, 3)
        assert depth.min() > 0 and 0 <= albedo.min() <= albedo.max() <= 1
        weight = np.cos(np.radians(90 - 180 / rows * (np.arange(rows) + 0.5)))
        share = np.average(globe._land(rows).mean(axis=1), weights=weight)
        assert share == pytest.approx(0.29, abs=0.02)


def test_a_normal_map_is_the_slope_of_its_heights():
    """A plane that rises by 0.3 along u and falls by 0.2 along v, on a surface of 2 by 3."""
    u, v = np.meshgrid((np.arange(32) + 0.5) / 32, (np.arange(16) + 0.5) / 16)
    normal = 2 * normal_map(0.3 * 2 * u - 0.2 * 3 * v, 2, 3)[1:-1, 1:-1] - 1
    expected = np.array([-0.3, 0.2, 1]) / np.linalg.norm([-0.3, 0.2, 1])
    np.testing.assert_allclose(normal, np.broadcast_to(expected, normal.shape), atol=1e-6)


def test_noise_is_continuous_centred_and_determined_by_its_seed():
    points = np.random.default_rng(0).uniform(-30, 30, (20_000, 3))
    for function in (noise.gradient, noise.fractal):
        values = function(points, seed=1)
        assert abs(values.mean()) < 0.05 and 0.1 < values.std() < 0.6
        np.testing.assert_allclose(function(points + 1e-5, seed=1), values, atol=1e-3)
        assert np.abs(function(points, seed=2) - values).mean() > 0.1
    first, second = noise.cells(points)
    assert (first >= 0).all() and (first <= second).all() and first.max() < np.sqrt(3)


@pytest.mark.parametrize("towards", [(1, 0, 0.2), (-1, -2, 1)])
def test_lights_are_in_the_stated_direction(tmp_path, towards):
    mi.set_variant("llvm_ad_rgb")
    dark = (0.01, 0.01, 0.01)
    light = stage.Light(towards, (0.2, 0.2), (5, 5, 5))
    sky = mi.load_dict(stage.surround(stage.Folder(tmp_path), dark, dark, dark, [light]))
    directions = np.random.default_rng(0).normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(-directions.T)
    seen, cosine = sky.eval(si).numpy()[0], directions @ towards / np.linalg.norm(towards)
    assert seen[cosine > np.cos(0.15)].min() > 4 and seen[cosine < np.cos(0.35)].max() < 0.02
