"""Updates of `openpbr` by `mi.traverse`: a changed material is one that is loaded so."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba.probes import bitmap, interaction, sampled
from tests.openpbr_surface import probes
from tests.openpbr_surface.probes import WALKS, anywhere, loaded, toward

from urushi.errors import ParameterError

pytestmark = pytest.mark.usefixtures("rgb")

#: A base under half a coat.
PLAIN = {"base_metalness": 0.0, "coat_weight": 0.5, "coat_roughness": 0.3, "coat_color": (1.0,) * 3}


ABOVE = np.random.default_rng(3).normal(size=(2, 40, 3)) * [1, 1, 0] + [0, 0, 1]
ABOVE /= np.linalg.norm(ABOVE, axis=-1, keepdims=True)

#: What is computed in a moment.
EXACT = {"energy_compensation": False}


def key_of(parameters, name):
    """The key of a parameter, wherever `mi.traverse` lists it."""
    (key,) = (key for key in list(parameters.keys()) if f".{key}".endswith(f".{name}"))
    return key


def update(parameters, **changes):
    """Change parameters by name, colours as tuples; parameters: a BSDF, or of `mi.traverse`."""
    if isinstance(parameters, mi.BSDF):
        parameters = mi.traverse(parameters)
    for name, value in changes.items():
        key = key_of(parameters, f"{name}.value")
        parameters[key] = type(parameters[key])(value)
    parameters.update()


def values(bsdf, repeats=1):
    """f at pairs on the sides that light comes from, the mean over `repeats` walks."""
    transmits = mi.has_flag(bsdf.flags(), mi.BSDFFlags.Transmission)
    return probes.values(bsdf, *(anywhere(80, 1) if transmits else ABOVE), repeats)


def same(bsdf, rtol=0.02, repeats=1, **parameters):
    """A changed material is the one that is loaded so."""
    expected = values(loaded(**parameters), repeats)
    np.testing.assert_allclose(values(bsdf, repeats), expected, rtol=rtol, atol=1e-6)


GLASS = {"interior": True, "transmission_weight": 1.0, "specular_roughness": 0.4}
PANE = {"geometry_thin_walled": True, "transmission_weight": 1.0, "specular_roughness": 0.4}
LEAF = {"geometry_thin_walled": True, "subsurface_weight": 1.0, "specular_roughness": 0.4}
COAT = {"coat_weight": 1.0, "coat_roughness": 0.5, "coat_color": (0.5,) * 3}
COLORS = ((0.3,) * 3, (0.8,) * 3)

#: Materials, a parameter, and the values that it takes one after the other.
SLABS = {
    "pane": (PANE | {"transmission_color": (0.5,) * 3}, "transmission_color", COLORS),
    "coated pane": (PANE | COAT, "coat_color", COLORS),
    "coated body": (GLASS | COAT, "coat_color", COLORS),
    "coated body of another index": (GLASS | COAT, "specular_ior", (1.3, 1.8)),
}
TWO_SIDED = {
    "glass": (GLASS, "specular_ior", (1.3, 1.8)),
    "leaf": (LEAF, "subsurface_color", COLORS),
    "half": (GLASS | {"transmission_weight": 0.5}, "base_color", COLORS),
    "pane appears": (PANE | WALKS, "specular_ior", (1.0, 1.5)),
    **{name: (before | EXACT, *change) for name, (before, *change) in SLABS.items()},
    **{f"{name}, walks": (before | WALKS, *x) for name, (before, *x) in SLABS.items()},
}
BASES = {
    "fuzz": ({}, "fuzz_weight", (0.6,)),
    "rough slab": ({}, "base_diffuse_roughness", (0.7,)),
    "some metal": ({}, "base_metalness", (0.4,)),
    "less metal": ({"base_metalness": 1.0}, "base_metalness", (0.4,)),
    "film": ({}, "thin_film_weight", (0.8,)),
    "index": ({}, "specular_ior", (1.9,)),
    # The factor of a base depends on it: 1.3 at a colour of 0.8, 1.5 at 0.4. After the first change
    # it is no constant.
    "colour of a coat without darkening": (
        {"coat_weight": 1.0, "coat_darkening": 0.0, "coat_roughness": 0.4},
        *("coat_color", ((0.7,) * 3, (0.4,) * 3)),
    ),
}


@pytest.mark.parametrize("name", BASES | TWO_SIDED)
def test_a_changed_material_is_the_one_that_is_loaded_so(few_paths, name):
    """Bases within the tables: those of any index are coarser than those of a number."""
    before, parameter, changes = (BASES | TWO_SIDED)[name]
    bsdf = loaded(**before)
    found = [values(bsdf)]
    for value in changes:
        update(bsdf, **{parameter: value})
        same(bsdf, 0.01 if name in BASES else 2e-3, **before | {parameter: value})
        assert bsdf.flags() == loaded(**before | {parameter: value}).flags()
        found.append(values(bsdf))
    assert not np.allclose(*found[-2:], rtol=0.01)


@pytest.mark.parametrize("reference", [pytest.param(False, marks=pytest.mark.slow), True])
def test_a_coat_appears_and_follows_its_parameters(reference):
    """From no coat: first its weight, then its colours, by the same list of parameters or anew.

    The walks draw the same numbers, and their mean loss is from another table.
    """
    shared = dict(coat_weight=0.8, coat_roughness=0.4)
    bsdf = loaded(coat_weight=0.0, reference=reference)
    old, walks = mi.traverse(bsdf), 512 if reference else 1
    update(old, **shared)
    shared |= dict(reference=reference)
    same(bsdf, repeats=walks, **shared)
    update(bsdf, coat_color=(0.5,) * 3)
    shared |= dict(coat_color=(0.5,) * 3)
    same(bsdf, repeats=walks, **shared)
    update(old, base_color=(0.2,) * 3)
    same(bsdf, repeats=walks, **shared, base_color=(0.2,) * 3)


def test_a_bitmap_of_one_value_is_a_number_until_it_varies():
    """Then, and where it has gradients, it is the texture that is loaded so, within the tables."""
    none, weights = np.zeros((2, 2, 1)), np.reshape([0.5, 0.5, 0.5, 1.0], (2, 2, 1))
    bsdf = loaded(**PLAIN | {"coat_weight": bitmap(none)})
    assert np.array_equal(values(bsdf), values(loaded(**PLAIN | {"coat_weight": 0.0})))
    parameters = mi.traverse(bsdf)
    key = key_of(parameters, "coat_weight.data")
    dr.enable_grad(parameters[key])
    parameters.update()
    same(bsdf, 1e-3, **PLAIN | {"coat_weight": bitmap(none)})
    parameters[key] = mi.TensorXf(np.float32(weights))
    parameters.update()
    same(bsdf, 0.01, **PLAIN | {"coat_weight": bitmap(weights)})


def test_the_gradient_of_a_weight_of_zero_is_that_of_the_part():
    """By the difference of two weights, to which f is linear."""
    bsdf = loaded()
    parameters = mi.traverse(bsdf)
    parameters["fuzz_weight.value"] = mi.Float(0)
    dr.enable_grad(parameters["fuzz_weight.value"])
    parameters.update()
    si, wo = interaction(toward(0.8, 0.0)[None]), mi.Vector3f(0.0, 0.6, 0.8)
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
    bsdf = loaded(**PLAIN | WALKS)
    before, parameters = values(bsdf), mi.traverse(bsdf)
    key = key_of(parameters, f"{name}.value")
    kept = np.array(parameters[key])
    with pytest.raises(ParameterError, match=f"openpbr: {name} is "):
        update(parameters, **{name: value})
    assert np.array_equal(np.array(parameters[key]), kept)
    assert np.array_equal(values(bsdf), before)
    update(bsdf, base_color=(0.3,) * 3)  # the next one is accepted
    same(bsdf, **PLAIN | WALKS, base_color=(0.3,) * 3)


def test_a_part_is_refused_in_the_words_of_the_material():
    """The coat is a plugin of its own, which the user has not written."""
    texels = [np.full((2, 2, 1), x, np.float32) for x in (0.3, np.nan)]

    def textured(texels):
        return loaded(id="paint", **PLAIN | WALKS | {"coat_roughness": bitmap(texels)})

    bsdf = textured(texels[0])
    sentence = "openpbr 'paint': a texel of alpha, which follows from coat_roughness, is nan"
    parameters = mi.traverse(bsdf)
    parameters["coat_roughness.data"] = mi.TensorXf(texels[1])
    with pytest.raises(ParameterError, match=sentence):
        parameters.update()
    assert np.array_equal(np.array(parameters["coat_roughness.data"]), texels[0])
    with pytest.raises(RuntimeError, match=sentence):
        textured(texels[1])
    wide = "openpbr: the bottom's alpha_u and alpha_v have a ratio of 12.* the option 'reference'"
    with pytest.raises(RuntimeError, match=wide):
        loaded(coat_weight=1.0, specular_roughness_anisotropy=1.0, **EXACT)


@pytest.mark.parametrize("reference", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_coat_of_index_one_is_its_medium_alone(reference):
    """coat_color is the square of the transmittance along the normal, without refraction.

    After updates, the light that the reference loses comes from 4,096 samples at each node, of a
    standard error of .3 % before means over nodes.
    """
    shared = dict(coat_weight=0.5, coat_ior=1.0, coat_roughness=0.4, reference=reference)
    clear, tinted = (loaded(coat_color=(c,) * 3, **shared) for c in (1.0, 0.3))
    bare = values(loaded())
    assert np.array_equal(values(clear), bare)
    passed = 0.5 + 0.5 * 0.3 ** (0.5 * (1 / ABOVE[..., 2]).sum(axis=0))
    np.testing.assert_allclose(values(tinted), bare * passed[:, None], rtol=1e-4)
    update(clear, coat_ior=1.6)
    update(clear, coat_ior=1.0)  # the coat remains, without an interface
    np.testing.assert_allclose(values(clear), bare, rtol=5e-3 if reference else 0.02)


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
        found = bsdf.eval_diffuse_reflectance(interaction(toward(cosine)[None])).numpy()[:, 0]
        expected = sampled(bsdf, toward(cosine), 1 << 16)[0][0].mean(axis=0)
        assert (found <= 1).all()
        np.testing.assert_allclose(found, expected, atol=0.07)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "glass"), [("base_color", False), ("base_metalness", False), ("coat_color", True)]
)
def test_a_bitmap_of_one_value_may_begin_to_vary(few_paths, name, glass):
    """A constant at first; then the material is the one that is loaded with the new texels."""
    channels = 3 if name.endswith("color") else 1
    texels = np.random.default_rng(0).uniform(0.2, 0.8, (4, 4, channels)).astype(np.float32)
    coat = dict(coat_weight=1.0, coat_roughness=0.3, transmission_weight=float(glass))
    bsdf = loaded(**coat, **{name: bitmap(np.full_like(texels, 0.5))})
    parameters = mi.traverse(bsdf)
    parameters[key_of(parameters, f"{name}.data")] = mi.TensorXf(texels)
    parameters.update()
    same(bsdf, 1e-4, **coat, **{name: bitmap(texels)})
