"""Parts of scenes: lights."""

import numpy as np
import pytest
from gallery import stage
from gallery.stage import Folder


@pytest.fixture(scope="module")
def mi():
    import mitsuba

    mitsuba.set_variant("llvm_ad_rgb")
    return mitsuba


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
