"""OpenPBR's bases that transmit light: energy, reciprocity, sampling, limits and bad input."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.mitsuba import sampling
from tests.mitsuba.latents.test_axes import albedo as albedo_of_samples
from tests.mitsuba.latents.test_axes import interactions, square
from tests.mitsuba.probes import interaction, sampled
from tests.openpbr_surface.probes import WALKS, WHITE, anywhere, loaded, toward, values

import urushi
from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.errors import ParameterError
from urushi.openpbr_surface.formulas import subsurface_albedo
from urushi.openpbr_surface.parameters import PARAMETERS
from urushi.walk.simulate import albedo

pytestmark = pytest.mark.usefixtures("rgb")

GLASS = {"transmission_weight": 1.0, "specular_ior": 1.5}
LEAF = {"geometry_thin_walled": True, "subsurface_weight": 1.0}
PANE = {"geometry_thin_walled": True, "transmission_weight": 1.0}
COAT = {"coat_weight": 1.0, "coat_roughness": 0.5, "specular_roughness": 0.4}


def load(material, **options):
    return loaded(interior=True, **material, **options)


def cosine_of(degrees):
    return np.cos(np.radians(degrees))


def light(bsdf, degrees, count=1 << 16):
    """Weights (C, N) and directions (N, 3) of samples for light of an angle to the upper normal."""
    weight, wo = sampled(bsdf, toward(cosine_of(degrees)), count)
    return weight[0].T, wo[0]


def test_samples_of_glass_follow_the_density_on_the_sphere():
    """Of the other closed forms, white furnaces in `test_laws` would be off."""
    bsdf = load(GLASS | {"specular_roughness": 0.3})
    for seed, degrees in enumerate((20, 70, 110, 160)):
        test = sampling.chi_squared(bsdf, degrees, seed, 1.5)
        assert test.run(0.01, test_count=4, quiet=True), test.messages


@pytest.mark.parametrize("degrees", [10, 150])
def test_filmed_glass_is_sampled_as_it_reflects(degrees):
    """The share of the samples that are reflected is that of the light, by the film's mean."""
    film = {"thin_film_weight": 1.0, "thin_film_ior": 2.4, "thin_film_thickness": 0.3}
    weight, wo = light(load(GLASS | film | {"specular_roughness": 0.3}), degrees)
    reflected = (wo[:, 2] > 0) == (degrees < 90)
    assert reflected.mean() > 0.1  # 0.04 without the film
    assert np.mean(weight * reflected) == pytest.approx(reflected.mean(), abs=0.01)


def test_rough_glass_is_that_of_mitsuba():
    """But for light that meets a second facet, which `roughdielectric` loses: up to 0.07 from
    inside, at grazing angles."""
    mine = load(GLASS | {"specular_roughness": 0.25})
    described = {"type": "roughdielectric", "distribution": "ggx", "alpha": 0.0625}
    theirs = mi.load_dict(described | {"int_ior": 1.5, "ext_ior": 1.0})
    wi, half = (anywhere(300, seed)[0] for seed in (3, 4))
    wo = 2 * (wi * half).sum(1, keepdims=True) * half - wi
    wo = np.where(np.arange(len(wo))[:, None] % 2, -wi * [0.7, 0.7, 1] + 0.1 * half, wo)
    wo /= np.linalg.norm(wo, axis=1, keepdims=True)
    keep = np.abs(wo[:, 2]) > 0.2
    one, other = (values(bsdf, wi[keep], wo[keep]) for bsdf in (mine, theirs))
    assert (other > 0.3).sum() > 50
    np.testing.assert_allclose(one, other, rtol=0.02, atol=0.08)
    assert np.all(one > other * (1 - 1e-3) - 1e-4)


def test_a_smooth_pane_has_the_shares_of_thindielectric():
    """The sum over all reflections inside is 2 R / (1 + R) (Fresnel); tables are within 1 %."""
    bsdf = load(PANE | {"specular_roughness": 0.0, "specular_ior": 1.5}, energy_compensation=False)
    for degrees in (10, 50, 130):
        weight, wo = light(bsdf, degrees)
        once = float(fresnel.dielectric(np.array(abs(cosine_of(degrees))), 1.5, NUMPY)[0])
        reflected = (wo[:, 2] > 0) == (degrees < 90)
        expected = 2 * once / (1 + once)
        assert np.mean(weight[0] * reflected) == pytest.approx(expected, abs=0.01)
        assert np.mean(weight[0] * ~reflected) == pytest.approx(1 - expected, abs=0.02)


@pytest.mark.parametrize(
    ("material", "name"), [(PANE, "transmission_color"), (GLASS | COAT, "coat_color")]
)
def test_colours_of_slabs_may_be_given_on_a_mesh(few_paths, material, name):
    """The table along a colour that is the same on the whole mesh has the albedo of the constant's,
    within the noise of samples."""
    mesh = square()  # lives as long as its points
    si, material = interactions(mesh), material | {"specular_roughness": 0.3}
    found = []
    for color in ({"type": "mesh_attribute", "name": "vertex_value"}, (0.3, 0.3, 0.3)):
        bsdf = load(material | {name: color}, energy_compensation=False)
        found.append(albedo_of_samples(bsdf, si))
    assert found[0] == pytest.approx(found[1], rel=0.02)


def test_a_leaf_splits_its_colour_as_the_specification_says():
    """Shares (1 - g) / 2 and (1 + g) / 2 of the light that its interface passes. Along the normal,
    without an interface, it is the diffuse transmission of `principledthin`."""
    color = np.array([0.2, 0.5, 0.8])
    colored = LEAF | {"subsurface_color": tuple(color), "subsurface_scatter_anisotropy": 0.5}
    weight, wo = light(load(colored), 40)
    passed = 1 - light(load(LEAF | {"subsurface_color": (0.0, 0.0, 0.0)}), 40)[0].mean()
    assert (weight * (wo[:, 2] < 0)).mean(1) == pytest.approx(0.75 * color * passed, rel=0.02)
    bare = load(colored | {"specular_weight": 0.0})
    thin = {"type": "principledthin", "base_color": {"type": "rgb", "value": [0.2, 0.5, 0.8]}}
    thin |= {"diff_trans": 1.5, "spec_trans": 0.0, "eta": 1.001, "roughness": 0.5}
    normal = np.array([[0, 0, 1.0]])
    f, theirs = (values(x, normal, -normal) for x in (bare, mi.load_dict(thin)))
    np.testing.assert_allclose(f, theirs, rtol=0.01)


def test_the_tint_is_met_once_on_the_way_through_a_coated_body():
    """Walks are the same for all tints: light that crosses the body's surface once has the factor
    of the tint, light from below that comes back from the coat its square."""
    color = (0.25, 0.5, 1.0)
    plain, tinted, dark = (
        load(GLASS | COAT | WALKS | {"transmission_color": c}) for c in (WHITE, color, (0.0,) * 3)
    )
    wi, wo = anywhere(100, 5)
    f, g, first = (values(bsdf, wi, wo) for bsdf in (plain, tinted, dark))
    crosses = (wi[:, 2] > 0).astype(int) + (wo[:, 2] > 0)  # 1: through
    for kind, power in ((2, 0), (1, 1), (0, 2)):
        at = crosses == kind
        back = first[at] if kind != 1 else 0.0
        expected = back + np.array(color) ** power * (f[at] - back)
        np.testing.assert_allclose(g[at], expected, rtol=1e-3, atol=1e-6)


def test_a_coated_body_is_a_slab():
    """Without compensation it is `urushi.slab` of the same interfaces, from both sides."""
    bsdf = load(GLASS | COAT | WALKS | {"coat_ior": 1.6, "coat_color": (0.5, 0.5, 0.5)})
    far = urushi.dielectric(0.16, 1.5 / 1.6)
    slab = urushi.slab(0.25, 1.6, sigma_t=0.5 * np.log(2), far=far)
    for degrees in (30, 130):
        weight, wo = light(bsdf, degrees, 1 << 17)
        through, wi = (wo[:, 2] > 0) != (degrees < 90), [toward(cosine_of(degrees))]
        for transmitted in (False, True):
            expected, se = albedo(slab, wi, walks=1 << 16, transmitted=transmitted)
            found = np.where(through == transmitted, weight[0], 0)
            error = np.hypot(found.std() / len(found) ** 0.5, se[0, 0])
            assert abs(found.mean() - expected[0, 0]) < 5 * error


def test_the_medium_of_a_body():
    """Beer's law at transmission_depth; absorption is shifted to have no negative channel."""
    deep = GLASS | {"transmission_color": (0.5, 0.25, 0.1), "transmission_depth": 2.0}
    medium = urushi.openpbr(**deep).on({"type": "sphere"})["interior"]
    sigma = medium["scale"] * np.array(medium["sigma_t"]["value"])
    assert np.exp(-2 * sigma) == pytest.approx([0.5, 0.25, 0.1])
    assert medium["albedo"]["value"] == [0, 0, 0]
    cloudy = urushi.openpbr(**deep, transmission_scatter=(1.0, 0.2, 0.2)).interior()
    sigma, single = (np.array(cloudy[name]["value"]) for name in ("sigma_t", "albedo"))
    sigma = cloudy["scale"] * sigma
    assert sigma * single == pytest.approx([0.5, 0.1, 0.1])
    absorbed = sigma * (1 - single)
    assert absorbed.min() == pytest.approx(0, abs=1e-12)
    expected = -np.log([0.5, 0.25, 0.1]) / 2 - [0.5, 0.1, 0.1]
    assert np.diff(absorbed) == pytest.approx(np.diff(expected))
    with pytest.raises(ParameterError, match="transmission_color is a texture, but the medium"):
        urushi.openpbr(**deep | {"transmission_color": CHECKER}).interior()


GREEN, PURPLE = (0.2, 0.6, 0.4), np.array([0.2, 0.1, 0.5])
TINT, SKIN = {"transmission_color": GREEN}, {"subsurface_color": tuple(PURPLE), "base_weight": 0.5}
MEDIA = {
    "subsurface": (
        SKIN | {"subsurface_weight": 0.8},
        {"base_color": tuple(0.8 * PURPLE + 0.2 * 0.5 * 0.8)},
    ),
    "depth": (GLASS | TINT | {"transmission_depth": 2.0}, GLASS | TINT),
    "scatter": (GLASS | {"transmission_scatter": GREEN, "transmission_depth": 2.0}, GLASS),
}


@pytest.mark.parametrize(("material", "surface"), MEDIA.values(), ids=MEDIA)
def test_a_bsdf_alone_has_no_medium(material, surface):
    """It is refused; where that is ignored, the body has no depth: its colours are the surface's.

    The base of subsurface_color is a mixture by subsurface_weight (OpenPBR Surface 1.1.1, 3.2.3).
    """
    alone = urushi.openpbr(**material)
    shape = alone.on({"type": "sphere"})
    assert mi.load_dict(shape).interior_medium() is not None
    with pytest.raises(RuntimeError, match="the medium inside of a body, and a BSDF has none"):
        alone.bsdf()
    ignored, (wi, wo) = loaded(**material, unsupported="ignore"), anywhere(80, 1)
    wi[:, 2] = np.abs(wi[:, 2])
    found, expected = (values(bsdf, wi, wo) for bsdf in (ignored, load(surface)))
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-6)


CHECKER = {"type": "checkerboard", "color0": 0.5, "color1": 1.0}


@pytest.mark.parametrize(
    "material",
    [
        {},
        GLASS,
        GLASS | {"transmission_depth": 1.0},
        PANE | WALKS | {"transmission_color": (0.5, 0.6, 0.7), "transmission_depth": 1.0},
        LEAF,
        {"transmission_weight": CHECKER, "transmission_color": CHECKER},
    ],
)
def test_opaque_and_clear_bodies_and_thin_walls_need_no_medium(material):
    described = urushi.openpbr(**material)
    assert described.interior() is None
    assert "interior" not in described.on({"type": "sphere"})
    mi.load_dict(described.description())


@pytest.mark.parametrize(("g", "index"), [(0.0, 1.4), (0.5, 1.4), (0.5, 0.8), (-0.3, 1.001)])
def test_the_medium_gives_a_body_its_subsurface_color(g, index):
    """The walk through a deep medium reflects that share of what enters, along the normal."""
    color = np.array([0.2, 0.5, 0.8])
    single = subsurface_albedo(color, g, index)
    assert subsurface_albedo(np.ones(3), g, index) == pytest.approx(1)
    assert subsurface_albedo(np.zeros(3), g, index) == pytest.approx(0)
    normal = [[0.0, 0.0, 1.0]]
    deep = urushi.coat(urushi.diffuse(0.0), 0.02, index, albedo=single, sigma_t=60.0, g=g)
    found, se = albedo(deep, normal, walks=1 << 13)
    f0 = ((index - 1) / (index + 1)) ** 2
    expected = f0 + (1 - f0) * color
    assert np.all(np.abs(found[0] - expected) < 0.005 * expected + 4 * se[0])


@pytest.mark.parametrize(
    ("name", "given", "taken"),
    [
        ("subsurface_scatter_anisotropy", 1.0, 0.99),
        ("subsurface_scatter_anisotropy", -1.0, -0.99),
        ("specular_ior", 0.0, 1 / 3),
        ("specular_ior", 9.0, 3.0),
        ("specular_weight", 100.0, 25.0),
    ],
)
def test_a_medium_has_the_colour_for_the_asymmetry_and_the_index_that_are_rendered(
    name, given, taken
):
    """Phase functions end at 0.99, and the indices of surfaces at 1/3 and 3."""
    one, other = (urushi.openpbr(subsurface_weight=1.0, **{name: x}) for x in (given, taken))
    assert one.interior()["albedo"]["value"] == pytest.approx(other.interior()["albedo"]["value"])
    assert one.interior()["phase"]["g"] == pytest.approx(other.interior()["phase"]["g"])


def test_a_body_has_the_medium_of_each_weight_that_is_a_texture():
    """A texture counts as a weight of one: of two textures, the medium is the mean of both."""
    half = urushi.openpbr(transmission_weight=CHECKER, subsurface_weight=1.0)
    scatters = urushi.openpbr(subsurface_weight=1.0).interior()
    assert half.interior() == scatters | {"scale": scatters["scale"] / 2}
    mi.load_dict(half.on({"type": "sphere"}))
    clear = GLASS | {"subsurface_weight": 1.0, "subsurface_color": CHECKER}
    assert urushi.openpbr(**clear).interior() is None  # nothing is left that scatters


@pytest.mark.parametrize(
    ("material", "names"),
    [
        ({}, {"base_color", "coat_color", "thin_film_weight", "fuzz_weight"}),
        (COAT | WALKS, {"base_color", "coat_color", "coat_ior", "specular_color"}),
        (GLASS, {"transmission_color", "specular_ior", "coat_weight", "thin_film_weight"}),
        (PANE | COAT | WALKS, {"transmission_color", "coat_color", "specular_ior"}),
        (LEAF | {"subsurface_weight": 0.5}, {"subsurface_color", "base_color"}),
    ],
    ids=["opaque", "coat", "glass", "coated pane", "half a leaf"],
)
def test_traverse_lists_parameters_by_their_names(material, names):
    bsdf = load(material | {"energy_compensation": False})
    keys = {*mi.traverse(bsdf).keys()} - {"latents", "table"}
    assert all(key.endswith(".value") for key in keys)
    found = {key.removesuffix(".value") for key in keys}
    assert names <= found <= PARAMETERS.keys()


@pytest.mark.parametrize(
    ("material", "sentence", "ignored"),
    [
        (GLASS | {"transmission_dispersion_scale": 1.0}, "needs dispersion, which the", True),
        (GLASS | {"fuzz_weight": 0.5}, "needs fuzz over a base that transmits light", True),
        (LEAF | {"coat_weight": 0.5}, "needs a coat on a thin wall that scatters", True),
        (PANE | {"thin_film_weight": 0.5}, "needs a thin film inside", False),
        (GLASS | COAT | {"thin_film_weight": 0.5}, "needs a thin film inside", False),
        (GLASS | {"specular_weight": CHECKER}, "is a texture, but what transmits light", False),
        (GLASS | {"specular_ior": 1.0, "thin_film_weight": 0.5}, "needs a film on a body", False),
    ],
)
def test_what_is_missing_is_refused_or_left_out(material, sentence, ignored):
    with pytest.raises(RuntimeError, match=f"openpbr: {[*material][-1]} {sentence}"):
        load(material)
    if ignored:
        assert load(material, unsupported="ignore") is not None


def test_a_metal_does_not_transmit():
    for metalness in (0.0, 1.0):
        flags = load(GLASS | {"base_metalness": metalness}).flags()
        assert mi.has_flag(flags, mi.BSDFFlags.Transmission) == (metalness == 0)
    with pytest.raises(RuntimeError, match="without a transmission component"):
        mi.load_dict({"type": "twosided", "b": urushi.openpbr(**GLASS).description()})


#: Two-sided surfaces of which a share is unseen; the share, and its transmittance along the normal
#: by the surface and by media that light crosses at an angle.
INDEX_ONE = {"coat_weight": 1.0, "coat_ior": 1.0, "coat_color": (0.6,) * 3}
TINTED = {"transmission_color": (0.5,) * 3}
UNSEEN = {
    "pane": (PANE | TINTED | {"specular_ior": 1.0}, 1.0, 1.0, 0.5),
    "pane without weight": (PANE | {"specular_weight": 0.0}, 1.0, 1.0, 1.0),
    "coated pane": (PANE | TINTED | INDEX_ONE | {"specular_ior": 1.0}, 1.0, 1.0, 0.5 * 0.6),
    "body": (GLASS | TINTED | {"specular_weight": 0.0}, 1.0, 0.5, 1.0),
    "coated body": (GLASS | TINTED | INDEX_ONE | {"specular_ior": 1.0}, 1.0, 0.5, 0.6**0.5),
    "half": (
        PANE | TINTED | {"specular_ior": 1.0, "transmission_weight": 0.5, "base_weight": 0.0},
        *(0.5, 1.0, 0.5),
    ),
}


@pytest.mark.parametrize("name", UNSEEN)
@pytest.mark.parametrize("degrees", [0, 50, 130])
def test_light_goes_straight_through_an_index_of_one(name, degrees):
    """By Beer's law (OpenPBR Surface 1.1.1: transmission_color is seen along the normal)."""
    material, share, surface, medium = UNSEEN[name]
    bsdf, cosine = load(material), abs(cosine_of(degrees))
    passed = share * surface * medium ** (1 / cosine)
    weight, wo = light(bsdf, degrees, 1 << 12)
    straight = np.abs(wo[:, 2] + cosine_of(degrees)) < 1e-4
    assert np.mean(straight) == pytest.approx(share, abs=0.01)
    assert np.mean(weight * straight) == pytest.approx(passed, rel=0.01)
    si = interaction(toward(cosine)[None])
    assert bsdf.eval_null_transmission(si).numpy() == pytest.approx(passed, rel=1e-4)
    if share == 1:
        assert not values(bsdf, np.tile([0.6, 0, 0.8], (100, 1)), anywhere(100, 1)[0]).any()


@pytest.mark.parametrize("name", ["specular_roughness", "specular_ior"])
def test_derivatives_of_slabs_are_refused_by_the_parameter(name):
    bsdf = load(PANE | WALKS)
    params = mi.traverse(bsdf)
    dr.enable_grad(params[f"{name}.value"])
    with pytest.raises(ParameterError, match=f"openpbr: {name} carries gradients"):
        params.update()
