"""A coat in the frame of a `normalmap`, and over a `mask` that is opaque."""

import numpy as np
import pytest
from tests.directions import above
from tests.mitsuba.probes import bitmap, vector

from urushi.mitsuba.reading import probing

COUNT = 2048
PIXELS = np.random.default_rng(0).uniform(0.1, 0.9, (4, 4, 3)).astype(np.float32)


#: Between texels the networks draw one of them by a hash of wi, which wrappers change.
NEAREST = {"filter_type": "nearest"}


@pytest.fixture
def coat(rgb, networks):
    """The dictionary of a textured coat."""
    return {
        "type": "neural_layered",
        "weights": str(networks),
        "albedo": bitmap(PIXELS) | NEAREST,
        "sigma_t": 0.7,
        "base": {"type": "roughconductor", "alpha": 0.3, "distribution": "ggx"},
    }


def interaction(mi, wi):
    si = probing.interaction(wi, np.random.default_rng(5).random((COUNT, 2)))
    si.t = 1.0
    return si


def evaluate(mi, bsdf, wi, wo) -> np.ndarray:
    """f cos and density of sampling (4, COUNT)."""
    si = interaction(mi, wi)
    f_cos, pdf = bsdf.eval_pdf(mi.BSDFContext(), si, vector(wo))
    return np.stack([*np.array(f_cos), np.array(pdf)])


def rotated(w: np.ndarray, tilt: float) -> np.ndarray:
    """Directions in the frame whose normal is tilted towards x."""
    cos, sin = np.cos(tilt), np.sin(tilt)
    return (w @ np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])).astype(np.float32)


def test_a_normal_map_tilts_the_frame(rgb, coat):
    tilt = 0.3
    normal = np.array([np.sin(tilt), 0, np.cos(tilt)])
    pixels = np.broadcast_to(0.5 + 0.5 * normal, (2, 2, 3))
    mapped = rgb.load_dict(
        {
            "type": "normalmap",
            "normalmap": bitmap(pixels),
            "use_shadowing_function": False,
            "inner": coat,
        }
    )
    # within these both directions are above both horizons
    wi, wo = (above(COUNT, seed, 0.5) for seed in (1, 2))
    inner = evaluate(rgb, rgb.load_dict(coat), rotated(wi, tilt), rotated(wo, tilt))
    # Mitsuba takes the cosine to the tilted normal, too
    np.testing.assert_allclose(evaluate(rgb, mapped, wi, wo), inner, rtol=2e-3)


@pytest.mark.parametrize("plugin", ["layered", "neural_layered"])
def test_an_opaque_mask_under_a_coat_is_none(rgb, plugin):
    """f is that of the coat over the BSDF in the mask, and other masks transmit light."""
    metal = {"type": "roughconductor", "alpha": 0.3, "distribution": "ggx"}
    masked = {"type": "mask", "inner": metal}
    wi, wo = above(COUNT, 1), above(COUNT, 2)
    found, expected = (
        probing.bsdf_values(rgb.load_dict({"type": plugin, "base": base}), wi, wo, wi[:, :2])
        for base in (masked | {"opacity": 1.0}, metal)
    )
    np.testing.assert_allclose(found, expected, rtol=1e-6)
    with pytest.raises(RuntimeError, match="the nested BSDF transmits light"):
        rgb.load_dict({"type": plugin, "base": masked | {"opacity": 0.9}})
