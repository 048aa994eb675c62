"""Surfaces that are known from their parameters, against Mitsuba's own evaluation of them."""

import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, f
from tests.untrained import untrained

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError
from urushi.material.encode import encode
from urushi.material.energy import limit_albedo
from urushi.mitsuba.reading import probing
from urushi.nets import lobe as lobes
from urushi.nets import weights
from urushi.nets.weights import Model
from urushi.textures.layering import transported

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
    "diffuse": {"type": "diffuse", "reflectance": COLOUR},
    "black plastic": PLASTIC | {"type": "roughplastic"},
    "black pplastic": PLASTIC | {"type": "pplastic"},
}
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


@pytest.fixture(scope="module")
def model() -> Model:
    return untrained(3)


@pytest.fixture(scope="module")
def file(model, tmp_path_factory):
    path = tmp_path_factory.mktemp("weights") / "lobed.safetensors"
    weights.save(path, model.arch, model.params, {})
    return path


@pytest.mark.parametrize("name", KNOWN)
def test_a_known_surface_has_the_values_of_the_bsdf(rgb, name):
    from urushi.mitsuba import spectrum
    from urushi.mitsuba.reading.known import known_surface

    bsdf = rgb.load_dict(KNOWN[name])
    uv, known = np.full((len(WI), 2), 0.5), known_surface(bsdf)
    values = lobes.f(probing.known_lobes(bsdf, uv), WI[:, None], WO[:, None])
    if known.reflectance is not None:
        channels = spectrum.channels_at(uv, lambda si, active: known.reflectance(si))
        values = values + channels.T / np.pi
    expected = probing.bsdf_values(bsdf, WI, WO, uv)
    # single precision of the half vector, in the steepest part of the lobe
    np.testing.assert_allclose(values, expected, rtol=5e-4, atol=1e-6)
    assert known.lobe_only == (name not in ("diffuse", "black plastic", "black pplastic"))


@pytest.mark.parametrize("name", UNKNOWN)
def test_other_bsdfs_are_known_by_their_values_alone(rgb, name):
    from urushi.mitsuba.reading.known import known_surface

    known = known_surface(rgb.load_dict(UNKNOWN[name]))
    assert known.lobes(None) is None and not known.lobe_only and known.reflectance is None


@pytest.mark.parametrize("name", MADE_AGAIN)
def test_a_bsdf_that_is_made_again_of_its_textures_reflects_the_same(rgb, name):
    from urushi.mitsuba.reading.changed import replaced

    bsdf = rgb.load_dict(MADE_AGAIN[name])
    np.testing.assert_array_equal(f(replaced(bsdf, lambda x: x), WI, WO), f(bsdf, WI, WO))


def test_a_bare_bsdf_is_encoded_exactly(rgb, model):
    bsdf = rgb.load_dict(KNOWN["gold"])
    expected = probing.bsdf_values(bsdf, WI, WO, np.full((len(WI), 2), 0.5))
    np.testing.assert_allclose(encode(bsdf, model).f(WI, WO), expected, rtol=5e-4, atol=1e-6)


@pytest.mark.parametrize("name", ("reflectance", "diffuse"))
def test_every_texel_of_a_surface_is_that_surface(rgb, model, file, name):
    """The codes under a coat are those of each texel's own surface.

    The reflectance is 8 x 6 texels, so that several texels and channels are equal.
    """
    rng = np.random.default_rng(0)
    pixels, widths = rng.integers(1, 5, (6, 8, 3)) / 4, rng.integers(1, 3, (6, 8, 1)) / 4
    base = KNOWN[name] | {
        "reflectance" if name == "diffuse" else "specular_reflectance": bitmap(pixels)
    }
    if name == "diffuse":
        values = np.broadcast_to(pixels[..., None] / np.pi, (*pixels.shape, model.arch.probes))
        codes = model.networks.encode(values, np.float32(lobes.NO_LOBE))
        bottom = limit_albedo(model, codes)
    else:
        base["alpha"] = bitmap(widths)
        none, one = np.zeros_like(pixels), np.ones_like(pixels)
        numbers = widths * one, pixels, pixels, none, 1.5 * one, none
        rest = np.tile(model.networks.empty_rest(), (*pixels.shape, 1))
        bottom = np.concatenate([np.stack(numbers, axis=-1), rest], axis=-1)
    coat = {"sigma_t": 0.5, "albedo": 0.5, "g": 0.0, "alpha": 0.1}
    bsdf = rgb.load_dict(
        {"type": "neural_layered", "weights": str(file), "int_ior": 1.5, "ext_ior": 1.0}
        | coat
        | {"base": base}
    )
    x, y = np.meshgrid((np.arange(8) + 0.5) / 8, (np.arange(6) + 0.5) / 6)
    found = bsdf.latents.at(np.float32([x.ravel(), y.ravel()]).T).reshape(6, 8, 3, -1)
    flat = bottom.reshape(-1, bottom.shape[-1]).astype(np.float32)
    columns = (({"eta": 1.5} | coat)[name] for name in CoatParameters._fields)
    under = CoatParameters.of_columns([np.full(len(flat), x, np.float32) for x in columns])
    expected = transported(model, flat, under).reshape(bottom.shape)
    of_texels, of_layer = (model.networks.f(z[..., None, :], WI, WO) for z in (found, expected))
    # The bits of textures leave an error of 0.07 % in the bottom and in the coat.
    assert (np.abs(of_texels - of_layer).mean(axis=-1) < 3e-3 * of_layer.mean(axis=-1)).all()


@pytest.mark.parametrize("value", (-0.5, np.nan))
@pytest.mark.parametrize("name", ("reflectance", "diffuse"))
def test_textures_without_a_meaning_are_refused(rgb, file, name, value):
    pixels = np.full((2, 2, 3), 0.5)
    pixels[1, 1, 2] = value
    own = "reflectance" if name == "diffuse" else "specular_reflectance"
    base = KNOWN[name] | {own: bitmap(pixels)}
    match = f"a texel of .* is {value}; it must be zero or more"
    with pytest.raises((ParameterError, RuntimeError), match=match):
        rgb.load_dict({"type": "neural_layered", "weights": str(file), "base": base})


def test_codes_of_textures_have_the_lobes_of_their_coats(rgb, model, file):
    albedo = bitmap(np.random.default_rng(0).random((2, 2, 3)))
    inner = {"type": "neural_layered", "weights": str(file), "albedo": albedo, "sigma_t": 1.0}
    inner["base"] = KNOWN["diffuse"]
    outer = {"type": "neural_layered", "weights": str(file), "alpha": 0.3, "base": inner}
    for coat, width in ((inner, 0.1), (outer, 0.3)):
        codes = rgb.load_dict(coat).latents.at(np.float32([[0.25, 0.25], [0.75, 0.25]]))
        assert codes.shape == (2, 3, model.arch.latent)
        np.testing.assert_allclose(codes[..., :4], np.broadcast_to([width, 0, 0, 1], (2, 3, 4)))
