"""Gradients of pictures, by Mitsuba's differentiable integrators, against finite differences."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, vector

from urushi.core.direction_sets import cosine_pairs
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
    """A scene as a function of one of its parameters, with derivatives of a weighted sum of pixels.

    All of the coat's parameters always carry gradients.
    """

    def __init__(self, mi, scene, spp=4):
        self.mi, self.scene, self.spp = mi, scene, spp
        self.parameters = mi.traverse(scene)
        self.keys = names(self.parameters)
        self.start = {
            key: type(self.parameters[key])(self.parameters[key]) for key in self.keys.values()
        }
        pixels = scene.sensors()[0].film().size()
        rng = np.random.default_rng(0)
        self.weights = mi.TensorXf(rng.uniform(0.5, 1.5, (*pixels, 3)).astype(np.float32))

    def attach(self, name=None, change=0.0):
        """Set all parameters to their first values, one of them changed, and attach all."""
        for key in self.keys.values():
            value = self.start[key]
            value = value + change if key == self.keys.get(name) else type(value)(value)
            self.parameters[key] = value
            dr.enable_grad(self.parameters[key])
        self.parameters.update()

    def render(self, seed=0):
        return self.mi.render(self.scene, self.parameters, spp=self.spp, seed=seed)

    def loss(self, image):
        return dr.sum(image * self.weights, axis=None)

    def backward(self, seed=0) -> dict[str, np.ndarray]:
        """Gradients of the loss with respect to all parameters, in one pass."""
        self.attach()
        dr.backward(self.loss(self.render(seed)))
        return {name: dr.grad(self.parameters[key]).numpy() for name, key in self.keys.items()}

    def forward(self, name, seed=0) -> float:
        """The loss's derivative with respect to a change of all of a parameter's numbers."""
        self.attach()
        image = self.render(seed)
        dr.set_grad(self.parameters[self.keys[name]], 1)
        change = dr.forward_to(image)
        return float(np.sum(change.numpy() * self.weights.numpy()))

    def difference(self, name, change, seed=0) -> float:
        """The same by a central difference, with the random numbers of the derivatives."""
        losses = []
        for way in (1, -1):
            self.attach(name, way * change)
            with dr.suspend_grad():
                image = self.render(self.mi.sample_tea_32(seed, 1)[0])
            losses.append(float(self.loss(image).numpy().item()))
        return (losses[0] - losses[1]) / (2 * change)


def test_backward_and_forward_against_differences(rgb):
    """Under a point light no sample depends on the material: the only error is that of the step.

    The third derivative of glossy materials, and errors of codes, add about one per cent.
    """
    picture = Picture(rgb, load(rgb, coat(rgb)))
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
    bottom = {
        "type": "roughplastic",
        "distribution": "ggx",
        "alpha": 0.15,
        "diffuse_reflectance": {"type": "rgb", "value": [0.4, 0.4, 0.4]},
    }
    plugin = rgb.load_dict({"type": "neural_layered", "alpha": 0.1, "bottom": bottom})
    parameters = rgb.traverse(plugin)
    key = "bottom.diffuse_reflectance.value"
    wi, wo = np.array([[0.6, 0, 0.8]] * 64), np.zeros((64, 3))
    wo[:, 0], wo[:, 2] = np.linspace(-0.9, 0.9, 64), np.sqrt(1 - np.linspace(-0.9, 0.9, 64) ** 2)

    def mean(value):
        parameters[key] = rgb.Color3f(value)
        parameters.update()
        si = probing.interaction(wi, np.full((64, 2), 0.5))
        return dr.mean(dr.sum(plugin.eval(rgb.BSDFContext(), si, rgb.Vector3f(wo.T))))

    number = rgb.Float(0.4)
    dr.enable_grad(number)
    result = mean(number)
    dr.backward(result)
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
        parameters = rgb.traverse(bsdf)
        key = next(x for x in list(parameters.keys()) if x in (f"{name}.data", f"{name}.value"))
        dr.enable_grad(parameters[key])
        parameters.update()
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
    picture = Picture(rgb, load(rgb, coat(rgb, bottom=inner)))
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
    parameters, key = rgb.traverse(bsdf), "albedo.value"
    assert parameters.flags("bottom.sigma_t.value") & rgb.ParamFlags.NonDifferentiable
    dr.enable_grad(parameters[key])
    parameters.update()
    si = probing.interaction(np.tile([[0, 0.6, 0.8]], (100, 1)), np.full((100, 2), 0.3))
    wo = rgb.warp.square_to_cosine_hemisphere(
        rgb.Point2f(np.random.default_rng(0).random((2, 100)))
    )
    dr.backward(dr.sum(bsdf.eval(rgb.BSDFContext(), si, wo), axis=None))
    assert (dr.grad(parameters[key]).numpy() > 0).all()


def test_plain_numbers_of_bottoms_have_gradients(rgb):
    """Numbers that cannot be textures, within a wrapper, against differences."""
    si = probing.interaction(np.tile([[0, 0.6, 0.8]], (100, 1)), np.full((100, 2), 0.3))
    u = rgb.Point2f(np.random.default_rng(0).random((2, 100)))
    wo = rgb.warp.square_to_cosine_hemisphere(u)

    def loaded(**changes):
        plastic = {"type": "roughplastic", "alpha": 0.3, "nonlinear": True} | changes
        return rgb.load_dict(coat(rgb, bottom={"type": "twosided", "bsdf": plastic}))

    def mean(bsdf):
        return dr.mean(bsdf.eval(rgb.BSDFContext(), si, wo), axis=None)

    bsdf = loaded()
    parameters, keys = rgb.traverse(bsdf), ("bottom.brdf_0.alpha", "bottom.brdf_0.eta")
    for key in keys:
        dr.enable_grad(parameters[key])
    parameters.update()
    dr.backward(mean(bsdf))
    found = [dr.grad(parameters[key]).numpy()[0] for key in keys]
    ends = [{"alpha": 0.28}, {"alpha": 0.32}, {"int_ior": 1.48}, {"int_ior": 1.5}]
    f = [mean(loaded(ext_ior=1.0, **({"int_ior": 1.49} | end))).numpy()[0] for end in ends]
    slopes = (f[1] - f[0]) / 0.04, (f[3] - f[2]) / 0.02
    np.testing.assert_allclose(found, slopes, rtol=0.1)


def test_gradients_that_codes_do_not_have_are_refused(rgb):
    walk = {"type": "layered", "sigma_t": 0.3, "bottom": {"type": "diffuse"}}
    parameters = rgb.traverse(rgb.load_dict(coat(rgb, bottom=walk, resolution=1)))
    dr.enable_grad(parameters["bottom.sigma_t.value"])
    with pytest.raises(ParameterError, match=r"the nested 'Layered' do not have; disable them"):
        parameters.update()


def test_saved_materials_have_gradients_of_their_codes(rgb, tmp_path):
    from urushi.material import encode

    path = tmp_path / "copper.safetensors"
    metal = rgb.load_dict({"type": "roughconductor", "material": "Cu"})
    encode(metal, WEIGHTS, table=False).save(path)
    bsdf = {"type": "neural_brdf", "filename": str(path), "weights": WEIGHTS}
    scene = load(rgb, bsdf)
    parameters = rgb.traverse(scene)
    key = "object.bsdf.latents"
    dr.enable_grad(parameters[key])
    parameters.update()
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
    parameters = rgb.traverse(bsdf)
    dr.enable_grad(parameters["alpha.value"])
    parameters.update()
    si = probing.interaction(np.tile([[0, 0.6, 0.8]], (100, 1)), np.full((100, 2), 0.3))
    u = np.random.default_rng(0).random((3, 100), np.float32)
    context = rgb.BSDFContext()
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
    parameters = rgb.traverse(scene)
    key = "object.bsdf.alpha.value"
    dr.enable_grad(parameters[key])
    parameters.update()
    found = rgb.render(scene, spp=4).numpy()
    assert np.abs(found - before).mean() < 0.02 * before.mean()
    dr.disable_grad(parameters[key])
    parameters.set_dirty(key)
    parameters.update()
    np.testing.assert_array_equal(rgb.render(scene, spp=4), before)


@pytest.mark.parametrize(("name", "end", "step"), (("albedo", 1.0, -0.005), ("sigma_t", 0.0, 0.02)))
def test_at_ends_of_ranges_are_one_sided_differences(rgb, name, end, step):
    """The mean of f changes as the quadratic through three values of tables; codes have 2 %."""
    medium = {"albedo": 0.8, "sigma_t": 6.0, "g": 0.6, "bottom": {"type": "diffuse"}}
    wi, wo = cosine_pairs(np.random.default_rng(0), 256, lowest_cosine=0.3)
    si = probing.interaction(wi, np.full((256, 2), 0.5))

    def mean(bsdf):
        return dr.mean(bsdf.eval(rgb.BSDFContext(), si, vector(wo)).x)

    def loaded(value):
        return rgb.load_dict(coat(rgb, **(medium | {name: value})))

    at = [mean(loaded(end + k * step))[0] for k in range(3)]
    expected = (4 * at[1] - 3 * at[0] - at[2]) / (2 * step)
    for value in (end, texture(rgb, end, end, channels=1)):
        bsdf = loaded(value)
        parameters = rgb.traverse(bsdf)
        key = next(x for x in parameters.keys() if x in (f"{name}.value", f"{name}.data"))  # noqa: SIM118
        dr.enable_grad(parameters[key])
        parameters.update()
        dr.backward(mean(bsdf))
        found = dr.grad(parameters[key]).numpy().sum()
        assert found == pytest.approx(expected, rel=0.025)
