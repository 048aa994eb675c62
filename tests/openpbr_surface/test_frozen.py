"""`openpbr` in Dr.Jit's frozen functions, which find the arrays of all its parts."""

import gc

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.plugins.test_frozen import no_garbage, picture, scene  # noqa: F401

MATERIALS = {
    "brushed, under a rough coat": {
        "specular_roughness_anisotropy": 0.5,
        "coat_weight": None,
        "coat_roughness": 0.3,
        "reference": True,
    },
    "coated glass": {"transmission_weight": 1.0, "coat_weight": 1.0, "coat_roughness": 0.2},
    "paper": {"geometry_thin_walled": True, "subsurface_weight": 1.0},
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MATERIALS)
def test_replays_use_changed_parameters(rgb, name):
    """None stands for a texture."""
    pixels = np.random.default_rng(0).uniform(0.3, 0.8, (4, 4, 1)).astype(np.float32)
    texture = {"type": "bitmap", "bitmap": rgb.Bitmap(pixels), "raw": True}
    given = {key: texture if x is None else x for key, x in MATERIALS[name].items()}
    loaded = scene(rgb, {"type": "openpbr", "specular_roughness": 0.3, **given})
    parameters = rgb.traverse(loaded)
    (key,) = (key for key, _ in parameters if key.endswith("specular_roughness.value"))
    frozen = dr.freeze(lambda loaded: picture(rgb, loaded, 0))
    for value in (0.3, 0.5):
        parameters[key] = value
        parameters.update()
        gc.collect()
        expected = picture(rgb, loaded, 0).numpy()
        np.testing.assert_allclose(frozen(loaded).numpy(), expected, rtol=1e-4)
