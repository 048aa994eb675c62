"""The plugin `layered_weidlich` against its model in NumPy, Mitsuba's bottoms and its sampler."""

import numpy as np
import pytest
from research.rivals import weidlich

import urushi
from urushi.errors import ParameterError

GOLD = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2, "eta": 0.2, "k": 3.9}
COAT = {"type": "layered_weidlich", "int_ior": 1.5, "ext_ior": 1.0}
COLOURS = (0.1, 1.0, 3.0)
ABSORBING = {"sigma_t": {"type": "rgb", "value": list(COLOURS)}}


def values(bsdf, wi, wo, uv=None) -> np.ndarray:
    from urushi.mitsuba.reading import probing

    return probing.bsdf_values(bsdf, wi, wo, np.zeros((len(wi), 2)) if uv is None else uv)


def test_values_are_the_models(rgb, random_directions):
    wi, wo = (random_directions(3000, seed, 0.05) for seed in (0, 1))
    plugin = COAT | ABSORBING | {"alpha": 0.1, "base": GOLD}
    stack = urushi.coat(urushi.conductor(0.2, eta=0.2, k=3.9), 0.1, 1.5, 0.0, COLOURS)
    np.testing.assert_allclose(
        values(rgb.load_dict(plugin), wi, wo), weidlich.f(stack, wi, wo), rtol=1e-3, atol=1e-6
    )
    below = plugin | {"int_ior": 1.2, "ext_ior": 0.8}
    twice = rgb.load_dict(COAT | {"alpha_u": 0.4, "alpha_v": 0.2, "int_ior": 0.8, "base": below})
    stack = urushi.coat(stack, alpha_u=0.4, alpha_v=0.2, eta=0.8)
    np.testing.assert_allclose(
        values(twice, wi, wo), weidlich.f(stack, wi, wo), rtol=1e-3, atol=1e-6
    )


@pytest.mark.parametrize(
    "base", (GOLD, {"type": "diffuse"}, {"type": "principled", "metallic": 0.5, "roughness": 0.3})
)
def test_a_coat_of_an_index_near_one_leaves_the_base(rgb, random_directions, base):
    wi, wo = (random_directions(1000, seed, 0.3) for seed in (2, 3))
    coat = rgb.load_dict(COAT | {"alpha": 0.2, "int_ior": 1.001, "base": base})
    np.testing.assert_allclose(
        values(coat, wi, wo), values(rgb.load_dict(base), wi, wo), rtol=0.02, atol=1e-5
    )


def test_absorption_is_beers_law(rgb):
    # At the normal, light crosses the coat twice. The coat's own reflection is that of a black one.
    up = np.float32([[0, 0, 1]])

    def at_normal(base, **medium):
        return values(rgb.load_dict(COAT | {"alpha": 0.2, "base": base} | medium), up, up)[0]

    surface = at_normal({"type": "diffuse", "reflectance": 0.0})
    clear, tinted = at_normal(GOLD) - surface, at_normal(GOLD, **ABSORBING) - surface
    np.testing.assert_allclose(tinted / clear, np.exp(-2 * np.array(COLOURS)), rtol=1e-3)


def test_coloured_widths_are_channels_of_their_own(rgb, random_directions):
    wi, wo = (random_directions(500, seed, 0.1) for seed in (4, 5))
    widths = 0.05, 0.2, 0.6
    colour = {"alpha": {"type": "rgb", "value": list(widths)}}
    f = values(rgb.load_dict(COAT | colour | {"base": GOLD}), wi, wo)
    for channel, alpha in enumerate(widths):
        grey = values(rgb.load_dict(COAT | {"alpha": alpha, "base": GOLD}), wi, wo)
        np.testing.assert_allclose(f[:, channel], grey[:, channel], rtol=1e-5)


def test_textures_and_changed_parameters_are_read(rgb, random_directions):
    wi, wo = (random_directions(400, seed, 0.2) for seed in (7, 8))
    pixels = rgb.Bitmap(np.float32([[[0.1], [0.5]]]))
    texture = {"type": "bitmap", "bitmap": pixels, "raw": True, "filter_type": "nearest"}
    bsdf = rgb.load_dict(COAT | {"alpha": texture, "base": GOLD})
    parameters = rgb.traverse(bsdf)
    parameters["eta"] = 1.7
    parameters.update()
    for u, alpha in ((0.25, 0.1), (0.75, 0.5)):
        plain = rgb.load_dict(COAT | {"alpha": alpha, "int_ior": 1.7, "base": GOLD})
        uv = np.tile([u, 0.5], (400, 1))
        np.testing.assert_allclose(values(bsdf, wi, wo, uv), values(plain, wi, wo), rtol=1e-4)
    parameters["eta"] = 9.0
    with pytest.raises(ParameterError, match="eta is 9"):
        parameters.update()


def test_samples_follow_the_normalised_density(rgb, sampling):
    narrow = GOLD | {"alpha": 0.02}
    first = COAT | {"alpha": 0.01, "base": narrow}
    coats = (
        first,
        COAT | {"alpha": 0.3, "base": {"type": "diffuse"}},
        COAT | ABSORBING | {"alpha": 0.2, "base": first},
        COAT | {"alpha_u": 0.1, "alpha_v": 0.4, "rotation": 30.0, "base": GOLD},
    )
    for seed, (degrees, coat) in enumerate(zip((0, 45, 70, 85), coats, strict=True)):
        test = sampling.chi_squared(rgb.load_dict(coat), degrees, seed)
        assert test.run(0.01, test_count=len(coats), quiet=True), (degrees, test.messages)
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.005)  # the quadrature of narrow lobes
        assert test.histogram_sum[0] == 1  # no sample fails


def test_coats_of_layered_are_no_coats_of_this_stack(rgb):
    bsdf = rgb.load_dict(COAT | {"alpha": 0.2, "base": {"type": "layered", "base": GOLD}})
    assert len(bsdf.coats) == 1
    assert str(bsdf).startswith("LayeredWeidlich[")


@pytest.mark.parametrize(
    "change, message",
    (
        ({"base": {"type": "dielectric"}}, "transmits light; a coat needs an opaque bottom"),
        ({"base": {"type": "conductor"}}, "perfectly smooth; give its rough variant"),
        ({"alpha": 2.0}, "alpha is 2; it must be a GGX width"),
        ({"second": {"type": "diffuse"}}, "has 2 nested BSDFs"),
    ),
)
def test_errors_name_mistakes(rgb, change, message):
    with pytest.raises(RuntimeError, match=f"layered_weidlich.*{message}"):
        rgb.load_dict(COAT | {"base": GOLD} | change)
