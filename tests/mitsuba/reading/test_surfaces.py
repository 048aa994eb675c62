"""Surfaces that are known from their parameters, against Mitsuba's own evaluation of them."""

import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, f

from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.changed import replaced
from urushi.mitsuba.reading.probing import known_surface
from urushi.nets import lobe as lobes

WI, WO = probe_pairs(192)
COLOUR = {"type": "rgb", "value": (0.9, 0.5, 0.2)}
GGX = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2}

PLASTIC = {"distribution": "ggx", "alpha": 0.2, "int_ior": 1.7, "specular_reflectance": 0.5} | {
    "diffuse_reflectance": 0.0
}

KNOWN = {
    "perfect reflector": GGX,
    "reflectance": GGX | {"specular_reflectance": COLOUR},
    "gold": GGX | {"material": "Au"},
    "glass": GGX | {"eta": 1.5, "k": 0.0, "specular_reflectance": COLOUR},
    "both sides": {"type": "twosided", "surface": GGX | {"material": "Cu"}},
    "black plastic": PLASTIC | {"type": "roughplastic"},
    "black pplastic": PLASTIC | {"type": "pplastic"},
}
DIFFUSE = {"type": "diffuse", "reflectance": COLOUR}
UNKNOWN = {
    "beckmann": GGX | {"distribution": "beckmann"},
    "plastic": {"type": "roughplastic"},
    "principled": {"type": "principled"},
}
ROUGH = {"type": "roughplastic", "alpha": 0.3, "diffuse_reflectance": 0.8}
NONLINEAR = ROUGH | {"nonlinear": True, "int_ior": 1.7, "ext_ior": 1.2}
MADE_AGAIN = {
    "both plastics": {"type": "blendbsdf", "weight": 0.4, "a": ROUGH, "b": NONLINEAR},
    "specular": {"type": "principled", "specular": 0.9},
    "eta": {"type": "principled", "eta": 1.8, "clearcoat": 0.5},
    "pplastic": {"type": "pplastic", "int_ior": 1.3, "alpha_u": 0.3, "alpha_v": 0.2},
}


@pytest.mark.parametrize("name", KNOWN)
def test_a_known_surface_has_the_values_of_the_bsdf(rgb, name):
    bsdf = rgb.load_dict(KNOWN[name])
    uv, known = np.full((len(WI), 2), 0.5), known_surface(bsdf)
    values = lobes.f(probing.known_lobes(bsdf, uv), WI[:, None], WO[:, None])
    expected = probing.bsdf_values(bsdf, WI, WO, uv)
    # single precision of the half vector, in the steepest part of the lobe
    np.testing.assert_allclose(values, expected, rtol=5e-4, atol=1e-6)
    assert known.lobe_only == (name not in ("black plastic", "black pplastic"))


def test_a_diffuse_surface_has_no_lobe(rgb):
    found = probing.known_lobes(rgb.load_dict(DIFFUSE), np.full((1, 2), 0.5))
    assert not lobes.f(found, WI[:, None], WO[:, None]).any()


@pytest.mark.parametrize("name", UNKNOWN)
def test_other_bsdfs_are_known_by_their_values_alone(rgb, name):
    known = known_surface(rgb.load_dict(UNKNOWN[name]))
    assert known.lobes(None) is None and not known.lobe_only


@pytest.mark.parametrize("name", MADE_AGAIN)
def test_a_bsdf_that_is_made_again_of_its_textures_reflects_the_same(rgb, name):
    bsdf = rgb.load_dict(MADE_AGAIN[name])
    np.testing.assert_array_equal(f(replaced(bsdf, lambda x: x), WI, WO), f(bsdf, WI, WO))


@pytest.mark.parametrize("value", (-0.5, np.nan))
@pytest.mark.parametrize("name", ("reflectance", "diffuse"))
def test_textures_without_a_meaning_are_refused(rgb, networks, name, value):
    pixels = np.full((2, 2, 3), 0.5)
    pixels[1, 1, 2] = value
    own = "reflectance" if name == "diffuse" else "specular_reflectance"
    base = (KNOWN | {"diffuse": DIFFUSE})[name] | {own: bitmap(pixels)}
    match = f"a texel of .* is {value}; it must be zero or more"
    with pytest.raises((ParameterError, RuntimeError), match=match):
        rgb.load_dict({"type": "neural_layered", "weights": str(networks), "base": base})


def test_codes_of_textures_have_the_lobes_of_their_coats(rgb, model, networks):
    albedo = bitmap(np.random.default_rng(0).random((2, 2, 3)))
    inner = {"type": "neural_layered", "weights": str(networks), "albedo": albedo, "sigma_t": 1.0}
    inner["base"] = DIFFUSE
    outer = {"type": "neural_layered", "weights": str(networks), "alpha": 0.3, "base": inner}
    for coat, width in ((inner, 0.1), (outer, 0.3)):
        codes = rgb.load_dict(coat).latents.at(np.float32([[0.25, 0.25], [0.75, 0.25]]))
        assert codes.shape == (2, 3, model.arch.latent)
        np.testing.assert_allclose(codes[..., :4], np.broadcast_to([width, 0, 0, 1], (2, 3, 4)))
