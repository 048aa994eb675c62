"""`neural_layered` and `neural_brdf` with two widths: parity with materials, frames, gradients."""

import numpy as np
import pytest
from tests.mitsuba.probes import vector

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.core.error_metrics import stack_error
from urushi.mitsuba.reading import probing
from urushi.nets.weights import anisotropic_model, default_model

BRUSHED = {"type": "roughconductor", "distribution": "ggx", "material": "Cu"}
METAL = BRUSHED | {"alpha_u": 0.3, "alpha_v": 0.1}
COAT = {"int_ior": 1.5, "ext_ior": 1.0, "albedo": 0.5, "sigma_t": 0.6}
WIDTHS = {"alpha_u": 0.08, "alpha_v": 0.3}


def coated(mi, base: dict, **parameters):
    return mi.load_dict({"type": "neural_layered", **COAT, "base": base, **parameters})


def values(mi, bsdf, wi, wo, uv=(0.5, 0.5)):
    """f [1/sr] (N, 3) and the density (N,)."""
    si = probing.interaction(wi, np.tile(uv, (len(wi), 1)))
    out = vector(wo)
    f_cos = bsdf.eval(mi.BSDFContext(), si, out).numpy()
    return f_cos.T / wo[:, 2:], bsdf.pdf(mi.BSDFContext(), si, out).numpy()


@pytest.fixture(scope="module")
def pairs():
    return cosine_pairs(np.random.default_rng(0), 2000, lowest_cosine=0.02)


def expected(mi, base: dict, **widths):
    top = urushi.dielectric(eta=1.5, **widths)
    return urushi.layer(top, mi.load_dict(base), albedo=0.5, sigma_t=0.6)


def test_plugins_are_materials(rgb, pairs, tmp_path):
    degrees = 35
    bsdf = coated(rgb, METAL, **WIDTHS, rotation=float(degrees))
    assert bsdf.model is anisotropic_model()
    material = expected(rgb, METAL, **WIDTHS)
    f, pdf = values(rgb, bsdf, *pairs)
    turned = [w.astype(np.float32) for w in (rotated(w, -degrees / 360) for w in pairs)]
    # Functions of 16 bits.
    assert stack_error(f.T, material.f(*turned).T, pairs[0][:, 2], pairs[1][:, 2]).max() < 0.002
    # The proposal is linear between 129 cosines.
    np.testing.assert_allclose(pdf, material.rotated(degrees).pdf(*pairs), rtol=0.03, atol=1e-3)
    bsdf.save(tmp_path / "saved.safetensors")
    saved = rgb.load_dict({"type": "neural_brdf", "filename": str(tmp_path / "saved.safetensors")})
    np.testing.assert_array_equal(values(rgb, saved, *pairs)[0], f)


def test_isotropic_coats_keep_their_networks(rgb):
    assert coated(rgb, {"type": "diffuse"}, alpha=0.1).model is default_model()
    assert coated(rgb, BRUSHED | {"alpha": 0.2}, alpha=0.1).model is default_model()


def test_a_bottom_that_becomes_anisotropic_gets_other_networks(rgb):
    bsdf = coated(rgb, BRUSHED | {"alpha_u": 0.2, "alpha_v": 0.2}, alpha=0.1)
    assert bsdf.model is default_model()
    parameters = rgb.traverse(bsdf)
    parameters["bottom.alpha_v.value"] = 0.05
    parameters.update()
    assert bsdf.model is anisotropic_model()


def test_textures_of_widths_and_angles(rgb, pairs):
    """Texels of 8 bits: f is within a percent; the angle is not quantised."""
    widths = {"alpha_u": ramp(rgb, 0.05, 0.3), "alpha_v": 0.15}
    grey = METAL | {"material": "none"}  # one channel of transport, not three
    bsdf = coated(rgb, grey, **widths, rotation=ramp(rgb, 0.0, 90.0))
    for u, alpha, degrees in ((0.25, 0.05, 0.0), (0.75, 0.3, 90.0)):
        material = expected(rgb, grey, alpha_u=alpha, alpha_v=0.15).rotated(degrees)
        f, _ = values(rgb, bsdf, *pairs, uv=(u, 0.5))
        assert np.median(np.abs(f / material.f(*pairs) - 1)) < 0.005


def ramp(mi, low: float, high: float) -> dict:
    """A texture of two texels, the left one low and the right one high."""
    data = np.array([[[low], [high]]], np.float32)
    bitmap = mi.Bitmap(data)
    return {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest"}


def test_textured_metal_under_a_coat(rgb, pairs):
    grey = BRUSHED | {"material": "none", "alpha_v": 0.2}
    base = grey | {"alpha_u": ramp(rgb, 0.1, 0.4)}
    bsdf = coated(rgb, base, alpha=0.1)
    assert bsdf.model is anisotropic_model()
    for u, alpha in ((0.25, 0.1), (0.75, 0.4)):
        material = expected(rgb, grey | {"alpha_u": alpha}, alpha=0.1)
        f, _ = values(rgb, bsdf, *pairs, uv=(u, 0.5))
        assert np.median(np.abs(f / material.f(*pairs) - 1)) < 0.005


@pytest.mark.slow
def test_gradients_of_widths_and_angle_agree_with_differences(rgb):
    """To 3 %. The azimuth changes f within a degree where a half vector is near an axis."""
    import drjit as dr

    wi, wo = cosine_pairs(np.random.default_rng(3), 64, lowest_cosine=0.3)
    si = probing.interaction(wi, np.full((64, 2), 0.5))
    weights = rgb.Float(np.random.default_rng(4).normal(size=64))
    out = vector(wo)
    bsdf = coated(rgb, METAL, alpha_u=0.25, alpha_v=0.4, rotation=20.0)
    parameters = rgb.traverse(bsdf)
    keys = ["alpha_u.value", "alpha_v.value", "rotation.value", "bottom.alpha_v.value"]
    start = {key: float(np.ravel(parameters[key].numpy())[0]) for key in keys}

    def mean(attached: bool = False, **changes) -> float:
        for key in keys:
            parameters[key] = start[key] + changes.get(key, 0.0)
            if attached:
                dr.enable_grad(parameters[key])
        parameters.update()
        return float(dr.sum(weights * bsdf.eval(rgb.BSDFContext(), si, out)[1]).numpy()[0])

    steps = {"alpha_u.value": 0.01, "alpha_v.value": 0.01, "rotation.value": 0.05}
    steps |= {"bottom.alpha_v.value": 0.004}
    differences = [
        (mean(**{key: steps[key]}) - mean(**{key: -steps[key]})) / (2 * steps[key]) for key in keys
    ]
    mean(attached=True)
    value = dr.sum(weights * bsdf.eval(rgb.BSDFContext(), si, out)[1])
    dr.backward(value)
    found = [float(np.ravel(dr.grad(parameters[key]).numpy())[0]) for key in keys]

    np.testing.assert_allclose(found, differences, rtol=0.03, atol=5e-4)
