"""Parts of the shipped scenes: shapes, patterns, maps, relief and lights."""

import numpy as np
import pytest
from tests.oracles.meshes import faces, signed_volume

from urushi.scenes import noise, stage, teapot
from urushi.scenes.options import Options
from urushi.scenes.stage import Folder


@pytest.fixture(scope="module")
def mi():
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


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


@pytest.mark.parametrize("towards", [(1, 0, 0.2), (0, 1, 0.2), (-1, -2, 1), (0.1, 0, 1)])
def test_lights_are_in_the_stated_direction(mi, tmp_path, towards):
    """The scene's emitter is brightest, and nearly only bright, in the light's direction."""
    dark = (0.01, 0.01, 0.01)
    light = stage.Light(towards, (0.2, 0.2), (5, 5, 5))
    sky = mi.load_dict(stage.surround(Folder(tmp_path), dark, dark, dark, [light]))
    rng = np.random.default_rng(0)
    directions = rng.normal(size=(4000, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    si = mi.SurfaceInteraction3f()
    si.wi = mi.Vector3f(-directions.T)
    seen = sky.eval(si).numpy()[0]
    cosine = directions @ towards / np.linalg.norm(towards)
    assert seen[cosine > np.cos(0.15)].min() > 4
    assert seen[cosine < np.cos(0.35)].max() < 0.02


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
