"""Gradients of f and of pictures against differences, and gradients that codes do not have."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, on_all_sides, slopes, spheres, vector

from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.material import encode
from urushi.mitsuba.reading import probing

METAL = {"type": "roughconductor", "material": "Cu", "distribution": "ggx"}
HALF, COLOUR = {"type": "rgb", "value": [0.5] * 3}, {"type": "rgb", "value": [0.3, 0.6, 0.8]}
GLASS = {"type": "roughdielectric", "distribution": "ggx", "int_ior": 1.5, "alpha": 0.2}
OPENPBR = {"type": "openpbr", "specular_roughness": 0.5, "interior": True}
CLEAR, LEAF = {"transmission_weight": 1.0}, {"subsurface_weight": 1.0, "subsurface_color": HALF}


def texture(low: float, high: float, channels: int = 3) -> dict:
    return bitmap(np.random.default_rng(channels).uniform(low, high, (4, 4, channels)))


def coat(**properties) -> dict:
    """A coat by the shipped networks: derivatives of random ones change within a step."""
    medium = {"albedo": COLOUR, "sigma_t": COLOUR, "g": 0.2}
    coat = {"type": "neural_layered", "alpha": 0.3, **medium, "bottom": METAL | {"alpha": 0.3}}
    return coat | properties


def textured_coat_below() -> dict:
    """A textured coat on a textured metal, below another coat."""
    rough = METAL | {"alpha": texture(0.15, 0.4, 1)}
    return coat(bottom=coat(albedo=texture(0.2, 0.8), bottom=rough))


def two_widths() -> dict:
    widths = {"alpha_u": 0.25, "alpha_v": 0.4, "rotation": 20.0}
    bottom = METAL | {"alpha_u": 0.3, "alpha_v": 0.1}
    return {"type": "neural_layered", "sigma_t": 0.6, "albedo": 0.5, "bottom": bottom} | widths


def plain_numbers() -> dict:
    """A bottom of numbers that cannot be textures, in a wrapper."""
    plastic = {"type": "roughplastic", "alpha": 0.3, "nonlinear": True}
    return coat(bottom={"type": "twosided", "bsdf": plastic})


def two_coats() -> dict:
    """The metal is relative to the index of the coat above it, not to that of the next one."""
    clear = {"sigma_t": 0.0, "albedo": 0.0}
    return coat(int_ior=1.4, bottom=coat(int_ior=1.6, **clear), **clear)


def body() -> dict:
    medium = {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}
    return {"type": "neural_layered", "int_ior": 1.3, "alpha": 0.1, "base": GLASS} | medium


#: Materials, steps by the keys of parameters, and the tolerance. Differences are of tables where
#: gradients are of codes, and of codes that are packed twice below another coat.
CASES = {
    "coat": (coat, {f"{x}.value": 0.01 for x in ("alpha", "albedo", "sigma_t")}, 0.01),
    "textures below a coat": (
        textured_coat_below, {"bottom.bottom.alpha.data": 0.03, "bottom.albedo.data": 0.03}, 0.1,
    ),
    "plain numbers": (
        plain_numbers, {"bottom.brdf_0.alpha": 0.02, "bottom.brdf_0.eta": 0.01}, 0.01,
    ),
    "indices": (two_coats, {"eta": 0.02, "bottom.eta": 0.02}, 0.05),
    "two widths": (
        two_widths,
        {"alpha_u.value": 0.01, "alpha_v.value": 0.01, "rotation.value": 0.05}
        | {"bottom.alpha_v.value": 0.004},
        0.05,
    ),
    "body": (body, {"sigma_t.value": 0.08}, 0.05),
    "glass": (lambda: OPENPBR | CLEAR, {"specular_roughness.value": 0.01}, 0.01),
    "leaf": (
        lambda: OPENPBR | LEAF | {"geometry_thin_walled": True},
        {"subsurface_color.value": 0.01},
        0.01,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_derivatives_of_f_are_differences(rgb, name):
    """Those of a weighted sum over pairs, by all numbers of a parameter together."""
    described, steps, tolerance = CASES[name]
    bsdf, rng = rgb.load_dict(described()), np.random.default_rng(3)
    wi, wo = cosine_pairs(rng, 256, lowest_cosine=0.3)
    if rgb.has_flag(bsdf.flags(), rgb.BSDFFlags.Transmission):
        wi, wo = on_all_sides(wi, wo)
    si = probing.interaction(wi, rng.random((256, 2)))
    weights = rgb.Spectrum(*np.float32(rng.uniform(0.5, 1.5, (3, 256))))

    def total():
        return dr.sum(dr.sum(weights * bsdf.eval(rgb.BSDFContext(), si, vector(wo))))

    found, expected = slopes(rgb.traverse(bsdf), steps, total)
    np.testing.assert_allclose(found, expected, rtol=tolerance)


def under_a_lamp(bsdf: dict):
    """A scene in which no sample depends on the material: derivatives have no noise."""
    described = spheres(bsdf, integrator="prb", depth=2)
    del described["sky"]
    return mi.load_dict(described)


def attached(loaded, *keys: str):
    """The parameters of a plugin or a scene, some of which carry gradients."""
    parameters = mi.traverse(loaded)
    for key in keys:
        dr.enable_grad(parameters[key])
    parameters.update()
    return parameters


def points(count: int = 100):
    """A context, surface interactions, and directions."""
    si = probing.interaction(np.tile([[0, 0.6, 0.8]], (count, 1)), np.full((count, 2), 0.3))
    u = mi.Point2f(np.random.default_rng(0).random((2, count)))
    return mi.BSDFContext(), si, mi.warp.square_to_cosine_hemisphere(u)


def test_pictures_have_derivatives_backward_and_forward(rgb):
    scene, key = under_a_lamp(coat()), "sphere0.bsdf.albedo.value"
    parameters, seed = rgb.traverse(scene), rgb.sample_tea_32(0, 1)[0]  # that of derivatives

    def light():
        own = 0 if dr.grad_enabled(parameters[key]) else seed
        return dr.sum(rgb.render(scene, parameters, spp=4, seed=own), axis=None)

    (backward,), (difference,) = slopes(parameters, {key: 0.01}, light)
    assert backward == pytest.approx(difference, rel=0.02)  # codes; tables
    total = light()
    dr.set_grad(parameters[key], 1)
    assert dr.forward_to(total).numpy().item() == pytest.approx(backward, rel=1e-3)


@pytest.mark.parametrize("textured", (False, True))
def test_pictures_are_the_same_once_gradients_are_disabled(rgb, few_points, textured):
    """With gradients, codes stand for tables: 2 % of the mean."""
    medium = {"albedo": texture(0.3, 0.9, 1)} if textured else {}
    scene, key = under_a_lamp(coat(**medium)), "sphere0.bsdf.alpha.value"
    before = rgb.render(scene, spp=4).numpy()
    parameters = attached(scene, key)
    found = rgb.render(scene, spp=4).numpy()
    assert np.abs(found - before).mean() < 0.02 * before.mean()
    dr.disable_grad(parameters[key])
    parameters.set_dirty(key)
    parameters.update()
    np.testing.assert_array_equal(rgb.render(scene, spp=4), before)


def test_saved_materials_have_gradients_of_their_codes(rgb, tmp_path):
    """f is linear in three numbers of the lobe; the gain is the logarithm of the rest's factor."""
    path, key = tmp_path / "copper.safetensors", "sphere0.bsdf.latents"
    encode(rgb.load_dict(METAL), table=False).save(path)
    scene = under_a_lamp({"type": "neural_brdf", "filename": str(path)})
    parameters = attached(scene, key)
    dr.backward(dr.sum(rgb.render(scene, parameters, spp=4), axis=None))
    slope, codes = dr.grad(parameters[key]).numpy(), parameters[key].numpy()
    gain = (slope[:, 1:4] * codes[:, 1:4]).sum(axis=1) + slope[:, 6]
    light = rgb.render(scene, spp=4, seed=rgb.sample_tea_32(0, 1)[0]).numpy().sum(axis=(0, 1))
    # Light is that of the table of the rest, whose error is below 1 %.
    np.testing.assert_allclose(gain, light, rtol=1e-2)


def test_a_number_in_all_channels_counts_once(rgb):
    """One variable in red, green and blue of a bottom: its slope is the sum over the channels."""
    bottom = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.15}
    bottom["diffuse_reflectance"] = {"type": "rgb", "value": [0.4, 0.4, 0.4]}
    plugin = rgb.load_dict({"type": "neural_layered", "alpha": 0.1, "bottom": bottom})
    parameters = rgb.traverse(plugin)

    def mean(value):
        parameters["bottom.diffuse_reflectance.value"] = rgb.Color3f(value)
        parameters.update()
        return dr.mean(dr.sum(plugin.eval(*points())))

    number = rgb.Float(0.4)
    dr.enable_grad(number)
    dr.backward(mean(number))
    expected = (mean(rgb.Float(0.43)) - mean(rgb.Float(0.37))) / 0.06
    assert dr.grad(number)[0] == pytest.approx(expected[0], rel=0.05)  # codes; tables


@pytest.mark.parametrize("name", ("albedo", "bottom.reflectance"))
def test_texels_of_one_value_have_gradients_of_their_own(rgb, name):
    """Their sum is the gradient of the number: all texels change together. Codes have 8 bits."""
    uv = np.random.default_rng(0).random((4096, 2))
    si = probing.interaction(np.tile(np.float32([0.6, 0, 0.8]), (4096, 1)), uv)
    found = []
    for value, end in ((HALF, "value"), (texture(0.5, 0.5), "data")):
        bottom = {"type": "diffuse"} | ({"reflectance": value} if name != "albedo" else {})
        bsdf = rgb.load_dict(coat(bottom=bottom, **({"albedo": value} if name == "albedo" else {})))
        parameters = attached(bsdf, f"{name}.{end}")
        dr.backward(dr.mean(bsdf.eval(rgb.BSDFContext(), si, rgb.Vector3f(0, 0.6, 0.8)).x))
        found.append(dr.grad(parameters[f"{name}.{end}"]).numpy())
    number, texels = found[0].ravel()[0], found[1][..., 0]
    assert texels.sum() == pytest.approx(number, rel=0.02)
    np.testing.assert_allclose(texels, texels.mean(), rtol=0.3)  # 256 points of uv for each


@pytest.mark.slow
def test_a_stochastic_bottom_has_no_gradient_but_its_coat_does(rgb, monkeypatch):
    monkeypatch.setattr(probing, "REPEATS", 64)  # noise does not matter here
    walk = {"type": "layered", "sigma_t": 0.3, "bottom": {"type": "diffuse"}}
    bsdf = rgb.load_dict(coat(bottom=walk))
    parameters = attached(bsdf, "albedo.value")
    assert parameters.flags("bottom.sigma_t.value") & rgb.ParamFlags.NonDifferentiable
    dr.backward(dr.sum(bsdf.eval(*points()), axis=None))
    assert (dr.grad(parameters["albedo.value"]).numpy() > 0).all()
    with pytest.raises(ParameterError, match=r"the nested 'Layered' do not have; disable them"):
        attached(bsdf, "bottom.sigma_t.value")


def test_directions_are_drawn_without_gradients(rgb):
    """Only f is differentiated; samples and densities are constant. The weight is f cos / pdf."""
    bsdf = rgb.load_dict(coat(albedo=texture(0.3, 0.9)))
    parameters, (context, si, _) = attached(bsdf, "alpha.value"), points()
    u = np.random.default_rng(0).random((3, 100), np.float32)
    sample, weight = bsdf.sample(context, si, rgb.Float(u[0]), rgb.Point2f(u[1:]))
    f_cos, pdf = bsdf.eval_pdf(context, si, sample.wo)
    assert not dr.grad_enabled(sample, pdf, bsdf.pdf(context, si, sample.wo))
    np.testing.assert_allclose(weight.numpy(), (f_cos / sample.pdf).numpy(), rtol=1e-5)
    changes = []
    for value in (weight.x, f_cos.x / sample.pdf):
        dr.set_grad(parameters["alpha.value"], 1)
        changes.append(dr.forward_to(value, flags=dr.ADFlag.ClearVertices).numpy())
    np.testing.assert_allclose(*changes, rtol=1e-4, atol=1e-5)
