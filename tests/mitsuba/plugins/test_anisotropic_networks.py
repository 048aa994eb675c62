"""`neural_layered` and `neural_brdf` with two widths: parity with materials, frames."""

import numpy as np
import pytest
from benchmarks.measures import stack_error
from tests.mitsuba.probes import f, strip, update, vector

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.mitsuba.reading import probing
from urushi.nets.weights import anisotropic_model, default_model

BRUSHED = {"type": "roughconductor", "distribution": "ggx", "material": "Cu"}
METAL = BRUSHED | {"alpha_u": 0.3, "alpha_v": 0.1}
COAT = {"int_ior": 1.5, "ext_ior": 1.0, "albedo": 0.5, "sigma_t": 0.6}
WIDTHS = {"alpha_u": 0.08, "alpha_v": 0.3}


def coated(mi, base: dict, **parameters):
    return mi.load_dict({"type": "neural_layered", **COAT, "base": base, **parameters})


PAIRS = cosine_pairs(np.random.default_rng(0), 2000, lowest_cosine=0.02)


def expected(mi, base: dict, **widths):
    top = urushi.dielectric(eta=1.5, **widths)
    return urushi.layer(top, mi.load_dict(base), albedo=0.5, sigma_t=0.6)


def test_plugins_are_materials(rgb, tmp_path):
    degrees = 35
    bsdf = coated(rgb, METAL, **WIDTHS, rotation=float(degrees))
    assert bsdf.model is anisotropic_model()
    material = expected(rgb, METAL, **WIDTHS)
    si = probing.interaction(PAIRS[0], np.full((len(PAIRS[0]), 2), 0.5))
    found, pdf = f(bsdf, *PAIRS), bsdf.pdf(rgb.BSDFContext(), si, vector(PAIRS[1])).numpy()
    turned = [w.astype(np.float32) for w in (rotated(w, -degrees / 360) for w in PAIRS)]
    # Functions of 16 bits.
    assert stack_error(found.T, material.f(*turned).T, *(w[:, 2] for w in PAIRS)).max() < 0.002
    # The proposal is linear between 129 cosines.
    np.testing.assert_allclose(pdf, material.rotated(degrees).pdf(*PAIRS), rtol=0.03, atol=1e-3)
    bsdf.save(tmp_path / "saved.safetensors")
    saved = rgb.load_dict({"type": "neural_brdf", "filename": str(tmp_path / "saved.safetensors")})
    np.testing.assert_array_equal(f(saved, *PAIRS), found)


def test_only_anisotropic_coats_and_bottoms_get_other_networks(rgb):
    equal = BRUSHED | {"alpha_u": 0.2, "alpha_v": 0.2}
    for base in ({"type": "diffuse"}, BRUSHED | {"alpha": 0.2}, equal):
        bsdf = coated(rgb, base, alpha=0.1)
        assert bsdf.model is default_model()
    update(bsdf, {"bottom.alpha_v.value": 0.05})
    assert bsdf.model is anisotropic_model()


def ramp(low: float, high: float) -> dict:
    """A texture of two texels, the left one low and the right one high."""
    return strip(low, high, filter_type="nearest")


@pytest.mark.parametrize("textured", ["coat", "bottom"])
def test_textures_of_widths_and_angles(rgb, textured):
    """Texels of 8 bits: f is within a percent; the angle is not quantised."""
    grey = METAL | {"material": "none"}  # one channel of transport, not three
    if textured == "coat":
        texture = {"alpha_u": ramp(0.05, 0.3), "rotation": ramp(0.0, 90.0)}
        bsdf = coated(rgb, grey, alpha_v=0.15, **texture)
        alone = [expected(rgb, grey, alpha_u=alpha, alpha_v=0.15) for alpha in (0.05, 0.3)]
        alone[1] = alone[1].rotated(90.0)
    else:
        bsdf = coated(rgb, grey | {"alpha_u": ramp(0.1, 0.4)}, alpha=0.1)
        alone = [expected(rgb, grey | {"alpha_u": alpha}, alpha=0.1) for alpha in (0.1, 0.4)]
    assert bsdf.model is anisotropic_model()
    for u, material in zip((0.25, 0.75), alone, strict=True):
        found = f(bsdf, *PAIRS, (u, 0.5))
        assert np.median(np.abs(found / material.f(*PAIRS) - 1)) < 0.005
