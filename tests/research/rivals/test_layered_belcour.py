"""The plugin `layered_belcour` against its model in NumPy, closed forms and its sampler."""

import numpy as np
import pytest
from research.rivals import belcour

import urushi
from urushi.errors import ParameterError

GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "eta": 0.2, "k": 3.9}
BRUSHED = {"type": "roughconductor", "distribution": "ggx", "alpha_u": 0.1, "alpha_v": 0.3}
COAT = {"type": "layered_belcour", "int_ior": 1.5, "ext_ior": 1.0}
COLOURS = (0.1, 1.0, 3.0)


def rgb_value(*values: float) -> dict:
    return {"type": "rgb", "value": list(values)}


def values(bsdf, wi, wo, uv=None) -> np.ndarray:
    from urushi.mitsuba.reading import probing

    return probing.bsdf_values(bsdf, wi, wo, np.zeros((len(wi), 2)) if uv is None else uv)


def agree(f, expected) -> None:
    """The plugin and the model: rounding, and a table of metals that is within 0.007."""
    np.testing.assert_allclose(f, expected, rtol=0.01, atol=1e-5)


@pytest.mark.parametrize("kind", ("conductor", "diffuse"))
def test_values_are_the_models(rgb, random_directions, kind):
    wi, wo = (random_directions(3000, seed, 0.05) for seed in (0, 1))
    bottoms = {
        "conductor": (GOLD, urushi.conductor(0.2, eta=0.2, k=3.9)),
        "diffuse": (
            {"type": "diffuse", "reflectance": rgb_value(0.9, 0.5, 0.1)},
            urushi.diffuse((0.9, 0.5, 0.1)),
        ),
    }
    nested, described = bottoms[kind]
    medium = {"albedo": 0.6, "g": 0.4}
    plugin = COAT | medium | {"alpha": 0.1, "sigma_t": rgb_value(*COLOURS), "base": nested}
    stack = urushi.coat(described, 0.1, 1.5, 0.6, COLOURS, 0.4)
    agree(values(rgb.load_dict(plugin), wi, wo), belcour.f(stack, wi, wo))
    below = plugin | {"int_ior": 1.2, "ext_ior": 0.8}
    twice = COAT | {"alpha": 0.4, "int_ior": 0.8, "base": below}
    agree(values(rgb.load_dict(twice), wi, wo), belcour.f(urushi.coat(stack, 0.4, 0.8), wi, wo))


def test_colours_are_channels_of_their_own(rgb, random_directions):
    wi, wo = (random_directions(500, seed, 0.1) for seed in (2, 3))
    colour = {"alpha": rgb_value(0.05, 0.2, 0.6), "sigma_t": rgb_value(0.1, 1, 3), "albedo": 0.8}
    f = values(rgb.load_dict(COAT | colour | {"base": GOLD}), wi, wo)
    for channel, (alpha, sigma_t) in enumerate(((0.05, 0.1), (0.2, 1.0), (0.6, 3.0))):
        grey = COAT | {"alpha": alpha, "sigma_t": sigma_t, "albedo": 0.8, "base": GOLD}
        np.testing.assert_allclose(f[:, channel], values(rgb.load_dict(grey), wi, wo)[:, channel])


def test_a_coat_that_is_hardly_there_leaves_the_rough_conductor(rgb, random_directions):
    # The index 1.001 reflects 2.5e-7 at the normal. A mirror's mean reflectance is one for all
    # facets, so that its lobe is exactly that of Mitsuba's own plugin.
    wi, wo = (random_directions(2000, seed, 0.3) for seed in (4, 5))
    mirror = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3, "material": "none"}
    coat = rgb.load_dict(COAT | {"alpha": 0.01, "int_ior": 1.001, "base": mirror})
    f, expected = values(coat, wi, wo), values(rgb.load_dict(mirror), wi, wo)
    # At a cosine of 0.3, this index stretches the variance by 1.1 %, and the peak falls by 1.7 %.
    np.testing.assert_allclose(f, expected, rtol=0.02)


def test_a_black_bottom_leaves_the_coats_lobe(rgb, random_directions):
    # The same shape as a rough conductor's of the coat's width, times a mean reflectance.
    wi = np.tile(np.float32([0.6, 0, 0.8]), (1000, 1))
    wo = random_directions(1000, 6, 0.1)
    black = {"type": "diffuse", "reflectance": 0.0}
    f = values(rgb.load_dict(COAT | {"alpha": 0.25, "base": black}), wi, wo)
    shape = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.25, "material": "none"}
    ratio = f / values(rgb.load_dict(shape), wi, wo)
    np.testing.assert_allclose(ratio, ratio[0, 0], rtol=1e-3)
    assert 0.04 < ratio[0, 0] < 0.08  # Fresnel's term at 37 degrees is 0.044, and it rises


def sampled_albedo(mi, bsdf, wi, count: int = 1 << 16) -> np.ndarray:
    """Mean weights (C,) of directions that the BSDF draws."""
    from urushi.mitsuba.reading import probing

    rng = np.random.default_rng(0)
    si = probing.interaction(np.tile(np.float32(wi), (count, 1)), np.zeros((count, 2)))
    u = (mi.Float(x) for x in rng.random((3, count), np.float32))
    first, *others = u
    weight = bsdf.sample(mi.BSDFContext(), si, first, mi.Point2f(*others))[1]
    return np.array([np.mean(channel.numpy()) for channel in weight])


@pytest.mark.parametrize("bottom", ("mirror", "white"))
@pytest.mark.parametrize("cos", (0.1, 0.5, 1.0))
def test_energy_is_at_most_one(rgb, bottom, cos):
    bottoms = {
        "mirror": {"type": "roughconductor", "distribution": "ggx", "material": "none"},
        "white": {"type": "diffuse", "reflectance": 1.0},
    }
    coat = COAT | {"alpha": 0.1, "base": bottoms[bottom]}
    wi = np.sqrt(1 - cos * cos), 0.0, cos
    for medium in ({}, {"sigma_t": 1.0, "albedo": 1.0, "g": 0.5}):
        albedo = sampled_albedo(rgb, rgb.load_dict(coat | medium), wi)
        assert (albedo <= 1.01).all()  # the mean of 65,536 weights near one
        assert (albedo > 0.2).all()


def coats() -> list[dict]:
    """Smooth and rough coats, over metal, a Lambertian surface, black, and another coat."""
    scattering = {"sigma_t": rgb_value(*COLOURS), "albedo": 0.9, "g": 0.2}
    narrow = GOLD | {"alpha": 0.02}
    black = {"type": "diffuse", "reflectance": 0.0}
    first = COAT | {"alpha": 0.01, "base": narrow}
    return [
        first,
        COAT | {"alpha": 0.3, "base": {"type": "diffuse"}},
        COAT | scattering | {"alpha": rgb_value(0.05, 0.1, 0.4), "base": GOLD},
        COAT | {"alpha": 0.6, "int_ior": 0.7, "base": black},
        COAT | scattering | {"alpha": 0.2, "int_ior": 1.9, "base": first},
        COAT | {"alpha": 0.05, "sigma_t": 20.0, "base": narrow},
    ]


def test_samples_follow_the_normalised_density(rgb, sampling):
    angles = 0, 45, 70, 89, 20, 60
    for seed, (degrees, coat) in enumerate(zip(angles, coats(), strict=True)):
        test = sampling.chi_squared(rgb.load_dict(coat), degrees, seed)
        assert test.run(0.01, test_count=len(angles), quiet=True), (degrees, test.messages)
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.005)  # the quadrature of narrow lobes
        assert test.histogram_sum[0] == 1  # no sample fails


def test_textures_are_read_at_each_point(rgb, random_directions):
    wi, wo = (random_directions(400, seed, 0.2) for seed in (7, 8))
    pixels = np.float32([[[0.1], [0.5]]])
    texture = {
        "type": "bitmap",
        "bitmap": rgb.Bitmap(pixels),
        "raw": True,
        "filter_type": "nearest",
    }
    bsdf = rgb.load_dict(COAT | {"alpha": texture, "base": GOLD | {"alpha": texture}})
    for u, alpha in ((0.25, 0.1), (0.75, 0.5)):
        plain = rgb.load_dict(COAT | {"alpha": alpha, "base": GOLD | {"alpha": alpha}})
        uv = np.tile([u, 0.5], (400, 1))
        np.testing.assert_allclose(values(bsdf, wi, wo, uv), values(plain, wi, wo), rtol=1e-4)


def test_changed_parameters_are_used(rgb, random_directions):
    wi, wo = (random_directions(400, seed, 0.2) for seed in (9, 10))
    bsdf = rgb.load_dict(COAT | {"alpha": 0.1, "base": GOLD})
    parameters = rgb.traverse(bsdf)
    parameters["alpha.value"], parameters["eta"] = 0.3, 1.8
    parameters["bottom.alpha.value"] = 0.4
    parameters.update()
    same = rgb.load_dict(COAT | {"alpha": 0.3, "int_ior": 1.8, "base": GOLD | {"alpha": 0.4}})
    np.testing.assert_allclose(values(bsdf, wi, wo), values(same, wi, wo), rtol=1e-5)
    parameters["alpha.value"] = 2.0
    with pytest.raises(ParameterError, match="alpha is 2; it must be a GGX width"):
        parameters.update()


@pytest.mark.parametrize(
    "change, message",
    (
        ({"base": {"type": "plastic"}}, "does not support the nested SmoothPlastic; nest a"),
        ({"base": GOLD | {"distribution": "beckmann"}}, "of the distribution 'ggx'"),
        ({"base": BRUSHED}, "nested RoughConductor; .* with one alpha"),
        ({"alpha_u": 0.1, "alpha_v": 0.3}, "isotropic lobes only; give alpha instead"),
        ({"rotation": 30.0}, "and no rotation"),
        ({"alpha": 2.0}, "alpha is 2; it must be a GGX width"),
        ({"second": {"type": "diffuse"}}, "has 2 nested BSDFs"),
    ),
)
def test_errors_name_mistakes(rgb, change, message):
    with pytest.raises(RuntimeError, match=f"layered_belcour.*{message}"):
        rgb.load_dict(COAT | {"base": GOLD} | change)
