"""`energy_compensation`: the white furnace, reciprocity, colours, and what is left as it is."""

import numpy as np
import pytest
from tests.directions import above, at_cosines
from tests.mitsuba.probes import f, sampled, strip, walked

import urushi

PLUGINS = ("layered", "neural_layered")
COSINES = (0.2, 0.6, 1.0)


def coat(name: str, on: bool = True, reflectance=1.0, **properties) -> dict:
    rgb = {"type": "rgb", "value": reflectance} if isinstance(reflectance, list) else reflectance
    base = {"type": "diffuse", "reflectance": rgb}
    return {"type": name, "energy_compensation": on, "int_ior": 1.5, "base": base, **properties}


def furnace(mi, bsdf: dict, count: int = 1 << 16, u: float = 0.0):
    """Directional albedos (cosines, 3) at a place by samples, and their standard errors."""
    weight, _ = sampled(mi.load_dict(bsdf), at_cosines(COSINES), count, (u, 0.5), "Radiance")
    return weight.mean(axis=1), weight.std(axis=1) / count**0.5


def test_the_lobe_is_reciprocal_and_coloured(rgb):
    """What is added, over cos wo, is symmetric, and has the order of the base's channels."""
    wi, wo = above(64, 1, 0.1), above(64, 2, 0.1)
    color = [0.8, 0.3, 0.05]
    on, off = (rgb.load_dict(coat("neural_layered", x, color, alpha=0.5)) for x in (True, False))
    added, exchanged = (f(on, *pair) - f(off, *pair) for pair in ((wi, wo), (wo, wi)))
    np.testing.assert_allclose(added, exchanged, rtol=1e-3, atol=1e-5)
    assert (added[:, 0] > added[:, 1]).all() and (added[:, 1] > added[:, 2]).all()


@pytest.mark.parametrize("name", PLUGINS)
def test_no_light_appears(rgb, name):
    """Over a dark base, over gold, and under an absorbing medium."""
    gold = {"type": "roughconductor", "material": "Au", "distribution": "ggx", "alpha": 0.2}
    dark = coat(name, reflectance=0.0, alpha=0.6)
    for bsdf in (dark, coat(name, alpha=0.6, sigma_t=3.0), dark | {"base": gold}):
        found, error = furnace(rgb, bsdf)
        assert (found < 1 + 5 * error).all()
    assert (furnace(rgb, dark)[0] < 0.15).all()  # what facets reflect, at most F at cosine 0.2


#: White coats: the plugin, its widths, and the tolerance; networks err by more.
WHITE = [
    ("layered", {"alpha": {"type": "rgb", "value": [0.1, 0.4, 0.8]}}, 0.005),
    ("layered", {"alpha_u": 0.4, "alpha_v": 0.05}, 0.005),
    ("neural_layered", {"alpha": 0.2}, 0.015),
    ("neural_layered", {"alpha": 0.6}, 0.015),
]


@pytest.mark.parametrize(("name", "widths", "tolerance"), WHITE)
def test_white_coats_reflect_all_light(rgb, name, widths, tolerance):
    """Within five standard errors, too."""
    found, error = furnace(rgb, coat(name, **widths), 1 << 14)
    assert (np.abs(found - 1) < tolerance + 5 * error).all()


@pytest.mark.parametrize("middle", (0.0, 1.0))
def test_texels_are_as_they_are_alone(rgb, middle):
    """A mask of metal and black. The middle of uv is in one of both. Within 1 %, the quadrature of
    what a texel mirrors, and five standard errors."""

    def base(metallic, color):
        return {"type": "principled", "metallic": metallic, "base_color": color, "roughness": 0.4}

    def mask(*texels):
        return strip(*texels, filter_type="nearest")

    values = np.float32([1 - middle, middle])
    masked = base(mask(*values), mask(*(0.05 + 0.9 * values)))
    for u, value in zip((0.25, 0.75), values, strict=True):
        alone = base(float(value), float(0.05 + 0.9 * value))
        (found, *errors), (expected, error) = (
            furnace(rgb, coat("layered", alpha=0.6, base=x), 1 << 14, u) for x in (masked, alone)
        )
        assert (np.abs(found - expected) < 0.01 + 5 * np.hypot(errors[0], error)).all()


@pytest.mark.parametrize("name", PLUGINS)
def test_plugins_agree_with_python(rgb, name):
    """Within 2 %, the error of the networks, and five standard errors."""
    color, w = [0.8, 0.3, 0.05], np.float32([[0.6, 0, 0.8], [0, 0.6, 0.8]])
    stack = urushi.coat(urushi.diffuse(color), 0.5, ior=1.5, energy_compensation=True)
    expected, error = urushi.simulate(stack, w[:1], w[1:], walks=1 << 14)
    loaded = rgb.load_dict(coat(name, reflectance=color, alpha=0.5))
    found = walked(loaded, w[:1], w[1:], 1 << 12)[:, 0]
    error = np.hypot(error[0], found.std(axis=0) / len(found) ** 0.5)
    assert (np.abs(found.mean(axis=0) - expected[0]) < 0.02 * expected[0] + 5 * error).all()


def test_no_surface_loses_nothing(rgb):
    wi, wo = above(32, 1, 0.1), above(32, 2, 0.1)
    equal = {"int_ior": 1.5, "ext_ior": 1.5, "sigma_t": 0.5, "alpha": 0.4}
    on, off = (rgb.load_dict(coat("layered", x) | equal) for x in (True, False))
    np.testing.assert_array_equal(f(on, wi, wo), f(off, wi, wo))
