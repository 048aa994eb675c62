"""Gradients of pictures, by Mitsuba's differentiable integrators, against finite differences."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap

from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing

#: The shipped networks: derivatives of random ones change too fast for finite differences.
WEIGHTS = "default"


def texture(mi, low, high, seed=0, channels=3) -> dict:
    pixels = np.random.default_rng(seed).uniform(low, high, size=(4, 4, channels))
    return bitmap(pixels)


def coat(mi, textured=False, **properties) -> dict:
    colour = {"type": "rgb", "value": [0.3, 0.6, 0.8]}
    return {
        "type": "neural_layered",
        "weights": WEIGHTS,
        "alpha": 0.3,
        "albedo": texture(mi, 0.3, 0.9) if textured else colour,
        "sigma_t": texture(mi, 0.3, 1.2, 1) if textured else colour,
        "g": 0.2,
        "bottom": {"type": "roughconductor", "material": "Cu", "alpha": 0.3, "distribution": "ggx"},
    } | properties


#: The point light of the scene.
LAMP = {"type": "point", "position": [2, 2, 4], "intensity": {"type": "rgb", "value": [20, 30, 40]}}


def load(mi, bsdf: dict):
    """A sphere over a grey floor."""
    to_world = mi.ScalarTransform4f()
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "prb", "max_depth": 2},
            "sensor": {
                "type": "perspective",
                "fov": 30,
                "to_world": to_world.look_at([0, 2, 5], [0, 0, 0], [0, 1, 0]),
                "film": {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}},
            },
            "light": LAMP,
            "floor": {"type": "rectangle", "to_world": to_world.translate([0, -1, 0]).rotate(
                [1, 0, 0], -90).scale(2), "bsdf": {"type": "diffuse"}},
            "object": {"type": "sphere", "bsdf": bsdf},
        }
    )  # fmt: skip


def names(parameters) -> dict[str, str]:
    """The coat's parameters, by their short names."""
    prefix = "object.bsdf."
    found = {}
    for key in parameters.keys():  # noqa: SIM118
        if key.startswith(prefix) and not key.endswith(("to_uv", "latents", "table")):
            found[key.removeprefix(prefix).removesuffix(".data").removesuffix(".value")] = key
    return found


class Picture:
    """A weighted sum of a scene's pixels as a function of the coat's parameters, which all carry
    gradients."""

    def __init__(self, mi, bsdf: dict):
        self.mi, self.scene = mi, load(mi, bsdf)
        self.parameters = mi.traverse(self.scene)
        self.keys = names(self.parameters)
        values = {name: self.parameters[key] for name, key in self.keys.items()}
        self.start = {name: type(value)(value) for name, value in values.items()}
        weights = np.random.default_rng(0).uniform(0.5, 1.5, (16, 16, 3))
        self.weights = mi.TensorXf(weights.astype(np.float32))

    def loss(self, changed=None, change=0.0, seed=0):
        """The sum at the first values of all parameters, one of which is changed."""
        for name, key in self.keys.items():
            value = self.start[name]
            self.parameters[key] = value + change if name == changed else type(value)(value)
            dr.enable_grad(self.parameters[key])
        self.parameters.update()
        image = self.mi.render(self.scene, self.parameters, spp=4, seed=seed)
        return dr.sum(image * self.weights, axis=None)

    def backward(self) -> dict[str, np.ndarray]:
        """Gradients with respect to all parameters, in one pass."""
        dr.backward(self.loss())
        return {name: dr.grad(self.parameters[key]).numpy() for name, key in self.keys.items()}

    def forward(self, name: str) -> float:
        """The derivative with respect to a change of all of a parameter's numbers."""
        loss = self.loss()
        dr.set_grad(self.parameters[self.keys[name]], 1)
        return dr.forward_to(loss).numpy().item()

    def difference(self, name: str, change: float) -> float:
        """The same by a central difference, with the random numbers of the derivatives."""
        seed = self.mi.sample_tea_32(0, 1)[0]
        low, high = (self.loss(name, x, seed).numpy().item() for x in (-change, change))
        return (high - low) / (2 * change)


def attached(mi, bsdf, *keys: str):
    """The parameters of a plugin, some of which carry gradients."""
    parameters = mi.traverse(bsdf)
    for key in keys:
        dr.enable_grad(parameters[key])
    parameters.update()
    return parameters


def points(mi, count: int = 100):
    """Surface interactions, directions, and a context in which they are evaluated."""
    si = probing.interaction(np.tile([[0, 0.6, 0.8]], (count, 1)), np.full((count, 2), 0.3))
    u = mi.Point2f(np.random.default_rng(0).random((2, count)))
    return mi.BSDFContext(), si, mi.warp.square_to_cosine_hemisphere(u)


def test_backward_and_forward_against_differences(rgb):
    """Under a point light no sample depends on the material: the only error is that of the step.

    The third derivative of glossy materials, and errors of codes, add about one per cent.
    """
    picture = Picture(rgb, coat(rgb))
    backward = picture.backward()
    assert set(backward) >= {"alpha", "albedo", "sigma_t", "g", "eta", "bottom.alpha", "bottom.k"}
    scale = 0.01 * float(max(np.abs(gradient).sum() for gradient in backward.values()))
    for name in ("alpha", "albedo", "sigma_t", "eta", "bottom.k"):
        expected = picture.difference(name, 0.01)
        gradient = backward[name].sum()
        assert gradient == pytest.approx(expected, rel=0.02, abs=0.01 * scale), name
    assert picture.forward("albedo") == pytest.approx(backward["albedo"].sum(), rel=1e-3)


def test_a_number_in_all_channels_counts_once(rgb):
    """One variable in red, green and blue of a bottom: its slope is the sum over the channels."""
    bottom = {"type": "roughplastic", "distribution": "ggx", "alpha": 0.15}
    bottom["diffuse_reflectance"] = {"type": "rgb", "value": [0.4, 0.4, 0.4]}
    plugin = rgb.load_dict({"type": "neural_layered", "alpha": 0.1, "bottom": bottom})
    parameters, (context, si, wo) = rgb.traverse(plugin), points(rgb)

    def mean(value):
        parameters["bottom.diffuse_reflectance.value"] = rgb.Color3f(value)
        parameters.update()
        return dr.mean(dr.sum(plugin.eval(context, si, wo)))

    number = rgb.Float(0.4)
    dr.enable_grad(number)
    dr.backward(mean(number))
    expected = (mean(rgb.Float(0.43)) - mean(rgb.Float(0.37))) / 0.06
    assert dr.grad(number)[0] == pytest.approx(expected[0], rel=0.05)  # codes; tables


@pytest.mark.parametrize(
    "name", (pytest.param("albedo", marks=pytest.mark.slow), "bottom.reflectance")
)
def test_texels_of_one_value_have_gradients_of_their_own(rgb, name):
    """Their sum is the gradient of the number: all texels change together. Codes have 8 bits."""
    own, count = name.split(".")[-1], 4096
    uv = np.random.default_rng(0).random((count, 2))
    si = probing.interaction(np.tile(np.float32([0.6, 0, 0.8]), (count, 1)), uv)
    found = []
    for value in ({"type": "rgb", "value": [0.5] * 3}, texture(rgb, 0.5, 0.5)):
        diffuse = {"type": "diffuse"} | ({own: value} if own == "reflectance" else {})
        changes = {"albedo": value} if own == "albedo" else {}
        bsdf = rgb.load_dict(coat(rgb, bottom=diffuse, **changes))
        key = f"{name}.value" if "value" in value else f"{name}.data"
        parameters = attached(rgb, bsdf, key)
        dr.backward(dr.mean(bsdf.eval(rgb.BSDFContext(), si, rgb.Vector3f(0, 0.6, 0.8)).x))
        found.append(np.array(dr.grad(parameters[key])))
    number, texels = found[0].ravel()[0], found[1][..., 0]
    assert texels.sum() == pytest.approx(number, rel=0.02)
    np.testing.assert_allclose(texels, texels.mean(), rtol=0.3)  # 256 points of uv for each


@pytest.mark.slow
def test_through_a_nested_coat_with_textured_bottom(rgb):
    metal = {"type": "roughconductor", "distribution": "ggx", "material": "Cu"}
    rough = metal | {"alpha": texture(rgb, 0.15, 0.4, channels=1)}
    inner = coat(rgb, albedo=texture(rgb, 0.2, 0.8), bottom=rough)
    picture = Picture(rgb, coat(rgb, bottom=inner))
    backward = picture.backward()
    for name in ("bottom.bottom.alpha", "bottom.albedo"):
        expected = picture.difference(name, 0.03)
        # Differences are of codes that are packed twice.
        assert backward[name].sum() == pytest.approx(expected, rel=0.1), name


@pytest.mark.slow
def test_a_stochastic_bottom_has_no_gradient_but_its_coat_does(rgb, monkeypatch):
    monkeypatch.setattr("urushi.mitsuba.reading.probing.REPEATS", 64)  # noise does not matter here
    walk = {"type": "layered", "sigma_t": 0.3, "bottom": {"type": "diffuse"}}
    bsdf = rgb.load_dict(coat(rgb, bottom=walk))
    parameters = attached(rgb, bsdf, "albedo.value")
    assert parameters.flags("bottom.sigma_t.value") & rgb.ParamFlags.NonDifferentiable
    dr.backward(dr.sum(bsdf.eval(*points(rgb)), axis=None))
    assert (dr.grad(parameters["albedo.value"]).numpy() > 0).all()


def test_gradients_that_codes_do_not_have_are_refused(rgb):
    walk = {"type": "layered", "sigma_t": 0.3, "bottom": {"type": "diffuse"}}
    bsdf = rgb.load_dict(coat(rgb, bottom=walk, resolution=1))
    with pytest.raises(ParameterError, match=r"the nested 'Layered' do not have; disable them"):
        attached(rgb, bsdf, "bottom.sigma_t.value")


def test_plain_numbers_of_bottoms_have_gradients(rgb):
    """Numbers that cannot be textures, within a wrapper, against differences."""

    def loaded(**changes):
        plastic = {"type": "roughplastic", "alpha": 0.3, "nonlinear": True} | changes
        return rgb.load_dict(coat(rgb, bottom={"type": "twosided", "bsdf": plastic}))

    def mean(bsdf):
        return dr.mean(bsdf.eval(*points(rgb)), axis=None)

    bsdf, keys = loaded(), ("bottom.brdf_0.alpha", "bottom.brdf_0.eta")
    parameters = attached(rgb, bsdf, *keys)
    dr.backward(mean(bsdf))
    found = [dr.grad(parameters[key]).numpy()[0] for key in keys]
    ends = [{"alpha": 0.28}, {"alpha": 0.32}, {"int_ior": 1.48}, {"int_ior": 1.5}]
    f = [mean(loaded(ext_ior=1.0, **({"int_ior": 1.49} | end))).numpy()[0] for end in ends]
    slopes = (f[1] - f[0]) / 0.04, (f[3] - f[2]) / 0.02
    np.testing.assert_allclose(found, slopes, rtol=0.1)


def test_indices_of_coats_over_metals_have_gradients(rgb):
    """The metal is relative to the index of the coat above it, not to that of the next one."""

    def loaded(outer=1.4, inner=1.6):
        below = coat(rgb, int_ior=inner, sigma_t=0.0, albedo=0.0)
        return rgb.load_dict(coat(rgb, int_ior=outer, sigma_t=0.0, albedo=0.0, bottom=below))

    def mean(bsdf):
        return dr.mean(bsdf.eval(*points(rgb)), axis=None)

    bsdf, keys = loaded(), ("eta", "bottom.eta")
    parameters = attached(rgb, bsdf, *keys)
    dr.backward(mean(bsdf))
    found = [dr.grad(parameters[key]).numpy()[0] for key in keys]
    ends = [{"outer": 1.36}, {"outer": 1.44}, {"inner": 1.56}, {"inner": 1.64}]
    f = [mean(loaded(**end)).numpy()[0] for end in ends]
    slopes = (f[1] - f[0]) / 0.08, (f[3] - f[2]) / 0.08
    np.testing.assert_allclose(found, slopes, rtol=0.1)


def test_saved_materials_have_gradients_of_their_codes(rgb, tmp_path):
    from urushi.material import encode

    path = tmp_path / "copper.safetensors"
    metal = rgb.load_dict({"type": "roughconductor", "material": "Cu"})
    encode(metal, WEIGHTS, table=False).save(path)
    bsdf = {"type": "neural_brdf", "filename": str(path), "weights": WEIGHTS}
    scene = load(rgb, bsdf)
    key = "object.bsdf.latents"
    parameters = attached(rgb, scene, key)
    image = rgb.render(scene, parameters, spp=4)
    dr.backward(dr.sum(image, axis=None))
    slopes, codes = dr.grad(parameters[key]).numpy(), parameters[key].numpy()
    # f is linear in three numbers of the lobe; the gain is the logarithm of a factor of the rest.
    gain = (slopes[:, 1:4] * codes[:, 1:4]).sum(axis=1) + slopes[:, 6]
    floor = load(rgb, {"type": "diffuse", "reflectance": 0})
    seed = rgb.sample_tea_32(0, 1)[0]
    light = [rgb.render(s, spp=4, seed=seed).numpy().sum(axis=(0, 1)) for s in (scene, floor)]
    # Light is that of the table of the rest, whose error is below 1 %.
    np.testing.assert_allclose(gain, light[0] - light[1], rtol=1e-2)


def test_directions_are_drawn_without_gradients(rgb):
    """Only f is differentiated; samples and densities are constant. The weight is f cos / pdf."""
    bsdf = rgb.load_dict(coat(rgb, textured=True))
    parameters, (context, si, _) = attached(rgb, bsdf, "alpha.value"), points(rgb)
    u = np.random.default_rng(0).random((3, 100), np.float32)
    sample, weight = bsdf.sample(context, si, rgb.Float(u[0]), rgb.Point2f(u[1:]))
    assert not dr.grad_enabled(sample)
    assert not dr.grad_enabled(bsdf.pdf(context, si, sample.wo))
    f_cos, pdf = bsdf.eval_pdf(context, si, sample.wo)
    assert dr.grad_enabled(f_cos) and not dr.grad_enabled(pdf)
    np.testing.assert_allclose(weight.numpy(), (f_cos / sample.pdf).numpy(), rtol=1e-5)
    changes = []
    for value in (weight.x, f_cos.x / sample.pdf):
        dr.set_grad(parameters["alpha.value"], 1)
        changes.append(dr.forward_to(value, flags=dr.ADFlag.ClearVertices).numpy())
    np.testing.assert_allclose(*changes, rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("textured", (False, True))
def test_pictures_are_the_same_once_gradients_are_disabled(rgb, textured):
    """With gradients, codes stand for tables: 2 % of the mean."""
    scene = load(rgb, coat(rgb, textured))
    before = rgb.render(scene, spp=4).numpy()
    key = "object.bsdf.alpha.value"
    parameters = attached(rgb, scene, key)
    found = rgb.render(scene, spp=4).numpy()
    assert np.abs(found - before).mean() < 0.02 * before.mean()
    dr.disable_grad(parameters[key])
    parameters.set_dirty(key)
    parameters.update()
    np.testing.assert_array_equal(rgb.render(scene, spp=4), before)
