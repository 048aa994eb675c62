"""Updates of `openpbr` by `mi.traverse`: a changed material is one that is loaded so."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing

pytestmark = pytest.mark.usefixtures("rgb")

#: A base under half a coat.
PLAIN = {"base_metalness": 0.0, "coat_weight": 0.5, "coat_roughness": 0.3, "coat_color": 1.0}


def loaded(**parameters):
    given = {
        name: {"type": "rgb", "value": [value] * 3} if name.endswith("color") else value
        for name, value in parameters.items()
    }
    return mi.load_dict({"type": "openpbr", **given})


def update(bsdf, **changes):
    """Change parameters by name, wherever `mi.traverse` lists them."""
    parameters = mi.traverse(bsdf)
    for name, value in changes.items():
        (key,) = (key for key in list(parameters.keys()) if f".{key}".endswith(f".{name}.value"))
        parameters[key] = type(parameters[key])(value)
    parameters.update()


def values(bsdf, repeats=1):
    """f at 40 pairs, the mean over `repeats` walks."""
    rng = np.random.default_rng(3)
    w = rng.normal(size=(2, 40, 3)) * [1, 1, 0] + [0, 0, 1]
    wi, wo = (np.tile(x / np.linalg.norm(x, axis=1, keepdims=True), (repeats, 1)) for x in w)
    time = np.repeat(np.arange(repeats), 40).astype(np.float32)
    f = probing.bsdf_values(bsdf, wi, wo, np.full((len(wi), 2), 0.5), time)
    return f.reshape(repeats, 40, -1).mean(0)


@pytest.mark.parametrize(
    ("before", "change"),
    [
        ({}, {"fuzz_weight": 0.6}),
        ({}, {"base_diffuse_roughness": 0.7}),
        ({}, {"base_metalness": 0.4}),
        ({"base_metalness": 1.0}, {"base_metalness": 0.4}),
        pytest.param({}, {"thin_film_weight": 0.8}, marks=pytest.mark.slow),
        ({}, {"specular_ior": 1.9}),
    ],
)
def test_a_changed_base_is_the_one_that_is_loaded_so(before, change):
    """Within the tables: those of any index are coarser than those of a number."""
    bsdf, former = loaded(**before), loaded(**before)
    update(bsdf, **change)
    expected = values(loaded(**(before | change)))
    np.testing.assert_allclose(values(bsdf), expected, rtol=0.01)
    assert not np.allclose(values(former), expected, rtol=0.01)


@pytest.mark.parametrize("reference", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_coat_appears_and_follows_its_parameters(reference):
    """From no coat: first its weight, then its colour, by the same list of parameters or anew."""
    bsdf = loaded(coat_weight=0.0, reference=reference)
    walks = 512 if reference else 1
    update(bsdf, coat_weight=0.8, coat_roughness=0.4)
    shared = dict(coat_weight=0.8, coat_roughness=0.4, reference=reference)
    # The walks draw the same numbers, and their mean loss is from another table.
    np.testing.assert_allclose(values(bsdf, walks), values(loaded(**shared), walks), rtol=0.02)
    update(bsdf, coat_color=0.5)
    expected = values(loaded(**shared, coat_color=0.5), walks)
    np.testing.assert_allclose(values(bsdf, walks), expected, rtol=0.02)
    update(bsdf, base_color=0.2)
    expected = values(loaded(**shared, coat_color=0.5, base_color=0.2), walks)
    np.testing.assert_allclose(values(bsdf, walks), expected, rtol=0.02)


@pytest.mark.slow
def test_a_base_without_darkening_follows_the_colour_of_its_coat():
    """The base's factor depends on it: 1.3 at a colour of 0.8, 1.5 at 0.4."""
    shared = dict(coat_weight=1.0, coat_darkening=0.0, base_color=0.5, coat_roughness=0.4)
    bsdf = loaded(**shared, coat_color=0.8)
    for color in (0.7, 0.4):  # after the first change it is no constant
        update(bsdf, coat_color=color)
        expected = values(loaded(**shared, coat_color=color))
        np.testing.assert_allclose(values(bsdf), expected, rtol=0.02)


@pytest.mark.research
def test_an_old_list_of_parameters_reaches_a_coat_that_was_made_later():
    bsdf = loaded(coat_weight=0.0)
    parameters = mi.traverse(bsdf)
    parameters["coat_weight.value"] = 1.0
    parameters.update()
    parameters["base_color.value"] = mi.Color3f(0.2)
    parameters.update()
    expected = values(loaded(coat_weight=1.0, base_color=0.2))
    np.testing.assert_allclose(values(bsdf), expected, rtol=0.02)


def test_a_bitmap_of_one_value_is_a_number_until_it_varies():
    """Then, and where it has gradients, it is the texture that is loaded so, within the tables."""

    def textured(texels):
        bitmap = mi.Bitmap(np.float32(texels).reshape(2, 2, 1))
        weight = {"type": "bitmap", "raw": True, "filter_type": "nearest", "bitmap": bitmap}
        return mi.load_dict({"type": "openpbr", **PLAIN, "coat_weight": weight})

    bsdf, weights = textured(np.zeros(4)), [0.5, 0.5, 0.5, 1.0]
    assert np.array_equal(values(bsdf), values(loaded(**PLAIN | {"coat_weight": 0.0})))
    parameters = mi.traverse(bsdf)
    (key,) = (key for key in list(parameters.keys()) if key.endswith("coat_weight.data"))
    dr.enable_grad(parameters[key])
    parameters.update()
    np.testing.assert_allclose(values(bsdf), values(textured(np.zeros(4))), rtol=1e-3)
    parameters[key] = mi.TensorXf(np.float32(weights).reshape(2, 2, 1))
    parameters.update()
    np.testing.assert_allclose(values(bsdf), values(textured(weights)), rtol=0.01)


def test_the_gradient_of_a_weight_of_zero_is_that_of_the_part():
    """By the difference of two weights, to which f is linear."""
    bsdf = loaded()
    parameters = mi.traverse(bsdf)
    parameters["fuzz_weight.value"] = mi.Float(0)
    dr.enable_grad(parameters["fuzz_weight.value"])
    parameters.update()
    si = probing.interaction(np.float32([[0.6, 0, 0.8]]), np.full((1, 2), 0.5))
    wo = mi.Vector3f(0.0, 0.6, 0.8)
    value = bsdf.eval(mi.BSDFContext(), si, wo)[0]
    dr.backward(value)
    found = parameters["fuzz_weight.value"].grad[0]
    none, half = (loaded(fuzz_weight=x).eval(mi.BSDFContext(), si, wo)[0][0] for x in (0.0, 0.5))
    assert found == pytest.approx((half - none) / 0.5, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "value"),
    [("base_color", 2.0), ("coat_weight", 2.0), ("specular_ior", float("nan")), ("coat_ior", -1.0)],
)
def test_a_refused_update_leaves_all_as_it_was(name, value):
    shared = PLAIN | {"reference": True, "energy_compensation": False}
    bsdf = loaded(**shared)
    before = values(bsdf)
    parameters = mi.traverse(bsdf)
    (key,) = (key for key in list(parameters.keys()) if f".{key}".endswith(f".{name}.value"))
    kept = np.array(parameters[key])
    parameters[key] = type(parameters[key])(value)
    with pytest.raises(ParameterError, match=f"openpbr: {name} is "):
        parameters.update()
    assert np.array_equal(np.array(parameters[key]), kept)
    assert np.array_equal(values(bsdf), before)
    update(bsdf, base_color=0.3)  # the next one is accepted
    np.testing.assert_allclose(values(bsdf), values(loaded(**shared, base_color=0.3)), rtol=0.02)


def test_a_part_is_refused_in_the_words_of_the_material():
    """The coat is a plugin of its own, which the user has not written."""
    texels = [np.full((2, 2, 1), x, np.float32) for x in (0.3, np.nan)]

    def textured(texels):
        rough = {"type": "bitmap", "raw": True, "bitmap": mi.Bitmap(texels)}
        walks = {"reference": True, "energy_compensation": False}
        return {"type": "openpbr", "id": "paint", **PLAIN, **walks, "coat_roughness": rough}

    bsdf = mi.load_dict(textured(texels[0]))
    sentence = "openpbr 'paint': a texel of alpha, which follows from coat_roughness, is nan"
    parameters = mi.traverse(bsdf)
    parameters["coat_roughness.data"] = mi.TensorXf(texels[1])
    with pytest.raises(ParameterError, match=sentence):
        parameters.update()
    assert np.array_equal(np.array(parameters["coat_roughness.data"]), texels[0])
    with pytest.raises(RuntimeError, match=sentence):
        mi.load_dict(textured(texels[1]))
    wide = "openpbr: the bottom's alpha_u and alpha_v have a ratio of 12.* the option 'reference'"
    with pytest.raises(RuntimeError, match=wide):
        loaded(coat_weight=1.0, specular_roughness_anisotropy=1.0)


@pytest.mark.parametrize("reference", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_coat_of_index_one_is_its_medium_alone(reference):
    """coat_color is the square of the transmittance along the normal, without refraction.

    After updates, the light that the reference loses comes from 4,096 samples at each node, of a
    standard error of .3 % before means over nodes.
    """
    rng = np.random.default_rng(3)
    w = rng.normal(size=(2, 40, 3)) * [1, 1, 0] + [0, 0, 1]
    cosines = 1 / np.linalg.norm(w, axis=-1)
    shared = dict(coat_ior=1.0, coat_roughness=0.4, reference=reference)
    clear, tinted = (loaded(coat_weight=0.5, coat_color=c, **shared) for c in (1.0, 0.3))
    bare = values(loaded())
    assert np.array_equal(values(clear), bare)
    passed = 0.5 + 0.5 * 0.3 ** (0.5 * (1 / cosines).sum(axis=0))
    np.testing.assert_allclose(values(tinted), bare * passed[:, None], rtol=1e-4)
    update(clear, coat_ior=1.6)
    update(clear, coat_ior=1.0)  # the coat remains, without an interface
    np.testing.assert_allclose(values(clear), bare, rtol=5e-3 if reference else 0.02)


@pytest.mark.parametrize("name", ["layered", "neural_layered"])
def test_a_refused_texture_is_put_back(name):
    texel = mi.Bitmap(np.full((2, 2, 1), 0.2, np.float32))
    alpha = {"type": "bitmap", "raw": True, "bitmap": texel}
    bsdf = mi.load_dict({"type": name, "alpha": alpha, "base": {"type": "diffuse"}})
    before, parameters = values(bsdf), mi.traverse(bsdf)
    for key, value in (("alpha.data", mi.TensorXf(np.full((2, 2, 1), 2.0))), ("eta", mi.Float(9))):
        kept = np.array(parameters[key])
        parameters[key] = value
        with pytest.raises(ParameterError, match="it must be"):
            parameters.update()
        assert np.array_equal(np.array(parameters[key]), kept)
        assert np.array_equal(values(bsdf), before)


@pytest.mark.parametrize(
    "bsdf",
    [
        {"type": "neural_layered", "alpha": 0.01,
         "base": {"type": "roughconductor", "material": "Au", "distribution": "ggx"}},
        pytest.param({"type": "openpbr", "coat_weight": 1.0, "fuzz_weight": 0.5},
                     marks=pytest.mark.slow),
    ],
)  # fmt: skip
def test_denoisers_get_the_directional_albedo(bsdf):
    """Mitsuba's default, pi f along the normal, is 35 for gold. Fixed samples have an error of some
    per cent; the albedo is by 65,536."""
    bsdf = mi.load_dict(bsdf)
    for cosine in (1.0, 0.3):
        wi = np.float32([[(1 - cosine**2) ** 0.5, 0, cosine]])
        found = bsdf.eval_diffuse_reflectance(probing.interaction(wi, np.full((1, 2), 0.5)))
        si = probing.interaction(np.tile(wi, (1 << 16, 1)), np.full((1 << 16, 2), 0.5))
        rng = mi.PCG32(size=1 << 16)
        u = mi.Point2f(rng.next_float32(), rng.next_float32())
        _, weight = bsdf.sample(mi.BSDFContext(), si, rng.next_float32(), u)
        expected = weight.numpy().mean(axis=1)
        assert (found.numpy() <= 1).all()
        np.testing.assert_allclose(found.numpy()[:, 0], expected, atol=0.07)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "glass"), [("base_color", False), ("base_metalness", False), ("coat_color", True)]
)
def test_a_bitmap_of_one_value_may_begin_to_vary(name, glass):
    """A constant at first; then the material is the one that is loaded with the new texels."""
    channels = 3 if name.endswith("color") else 1
    texels = np.random.default_rng(0).uniform(0.2, 0.8, (4, 4, channels)).astype(np.float32)

    def with_texels(texels):
        texture = {"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True}
        coat = {"coat_weight": 1.0, "coat_roughness": 0.3, "transmission_weight": float(glass)}
        return mi.load_dict({"type": "openpbr", **coat, name: texture})

    bsdf = with_texels(np.full_like(texels, 0.5))
    parameters = mi.traverse(bsdf)
    (key,) = (key for key, _ in parameters if key.endswith(f"{name}.data"))
    parameters[key] = mi.TensorXf(texels)
    parameters.update()
    np.testing.assert_allclose(values(bsdf), values(with_texels(texels)), rtol=1e-4)
