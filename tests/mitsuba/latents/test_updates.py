"""After a change through `mi.traverse`, codes are those of a coat that is loaded anew."""

import mitsuba as mi
import numpy as np
import pytest
from tests.directions import pairs_near_mirrors
from tests.mitsuba import probes
from tests.mitsuba.probes import bitmap

from urushi.errors import ParameterError

SIDE = 16


def noise(channels: int, seed: int = 0) -> np.ndarray:
    """Numbers that are all different, from 0.1 to 0.9."""
    numbers = np.linspace(0.1, 0.9, SIDE * SIDE * channels)
    return np.random.default_rng(seed).permutation(numbers).reshape(SIDE, SIDE, channels)


def described(networks, **properties) -> dict:
    return {
        "type": "neural_layered",
        "weights": str(networks),
        "alpha": 0.2,
        "albedo": bitmap(noise(3)),
        "sigma_t": 0.8,
        "base": {"type": "diffuse", "reflectance": bitmap(noise(3, 1))},
        **properties,
    }


def changed(bsdf, values: dict) -> None:
    """Set parameters to numbers and arrays."""
    tensors = {k: x if np.ndim(x) == 0 else mi.TensorXf(np.float32(x)) for k, x in values.items()}
    probes.update(bsdf, tensors)


def codes(bsdf) -> np.ndarray:
    """Codes at points that cover uv."""
    return bsdf.latents.at(np.random.default_rng(3).random((512, 2)))


def check_equal(bsdf, fresh) -> None:
    """Codes are equal up to what lies between nodes, which follow from the ranges of parameters."""
    found, expected = codes(bsdf), codes(fresh)
    assert np.abs(found - expected).max() <= np.ptp(expected) / 50


def test_changes_of_numbers_and_textures(rgb, networks):
    bsdf = rgb.load_dict(described(networks))
    narrow, wide = 0.2 + 0.6 * noise(3, 2), 1.2 * noise(3, 3) - 0.1
    larger, now = np.repeat(noise(3), 2, axis=0), {"sigma_t": 2.0}
    base = {"type": "diffuse", "reflectance": bitmap(narrow)}
    for given, properties in (
        ({"sigma_t.value": 2.0, "albedo.data": narrow}, {"albedo": bitmap(narrow)}),
        ({"albedo.data": wide}, {"albedo": bitmap(wide)}),
        (
            {"albedo.data": larger, "bottom.reflectance.data": narrow},
            {"albedo": bitmap(larger), "base": base},
        ),
    ):
        changed(bsdf, given)
        check_equal(bsdf, rgb.load_dict(described(networks, **now | properties)))


def test_changes_within_ranges_bake_nothing(rgb, networks, few_points):
    """Unless they change what two parameters of one texture have to do with each other."""
    one = {"type": "neural_layered", "body": 0.6, "body_color": bitmap(noise(3))}
    for coat, kept, baking in (
        (
            described(networks),
            {"albedo.data": 0.2 + 0.6 * noise(3), "bottom.reflectance.data": noise(3, 2)},
            {"sigma_t.value": 2.0},
        ),
        (
            one | {"base": {"type": "diffuse"}},
            {"body_color.data": noise(3)[::-1].copy()},
            {"body.value": 0.4},  # of the same colours, other depths
        ),
    ):
        bsdf = rgb.load_dict(coat)
        baked = bsdf.latents.baked
        changed(bsdf, kept)
        assert bsdf.latents.baked is baked
        changed(bsdf, baking)
        assert bsdf.latents.baked is not baked


def test_changes_of_nested_bsdfs(rgb, networks, few_points):
    """A constant of a textured bottom, and a texture of a nested coat."""
    base = {"type": "roughconductor", "alpha": bitmap(noise(1)), "distribution": "beckmann"}
    inner, pixels = described(networks), noise(3)
    pixels[0, 0] = 0.95
    for below, key, value, changes in (
        (base, "bottom.eta.value", 0.5, {"eta": 0.5, "k": 1.0}),
        (inner, "bottom.albedo.data", pixels, {"albedo": bitmap(pixels)}),
    ):
        bsdf = rgb.load_dict(described(networks, albedo=0.5, base=below))
        changed(bsdf, {key: value})
        fresh = described(networks, albedo=0.5, base=below | changes)
        check_equal(bsdf, rgb.load_dict(fresh))


def test_a_change_out_of_range_can_be_taken_back(rgb, networks, few_points):
    """But for a bitmap of four channels, which Mitsuba would read beyond its end."""
    bsdf = rgb.load_dict(described(networks))
    before = codes(bsdf)
    with pytest.raises(ParameterError, match="albedo is .*; it must be"):
        changed(bsdf, {"albedo.data": noise(3) + 1})
    changed(bsdf, {"albedo.data": noise(3)})
    np.testing.assert_array_equal(codes(bsdf), before)
    with pytest.raises((ParameterError, RuntimeError), match="changed to .*4 channels"):
        changed(bsdf, {"albedo.data": noise(4)})


@pytest.mark.parametrize("plugin", ("neural_layered", "layered"))
def test_a_refused_change_leaves_all_coats_as_they_were(rgb, networks, plugin):
    """Of two nested coats and their bottom, whichever is refused, in a wrapper."""

    def coat(below, **properties) -> dict:
        return {"type": plugin, "weights": str(networks), "alpha": 0.2, "on": below, **properties}

    inner = coat({"type": "diffuse"}, albedo=0.5, sigma_t=1.0)
    bsdf = rgb.load_dict(coat({"type": "twosided", "front": inner}, sigma_t=0.1))
    parameters, directions = rgb.traverse(bsdf), pairs_near_mirrors(64)
    keys = ["alpha.value", *(f"bottom.brdf_0.{x}.value" for x in ("albedo", "bottom.reflectance"))]
    before, f = {key: str(parameters[key]) for key in keys}, probes.f(bsdf, *directions)
    for alpha, albedo in ((0.3, 1.5), (1.5, 0.6)):
        with pytest.raises(ParameterError, match="is 1.5; it must be"):
            parameters.update(dict(zip(keys, (alpha, albedo, 0.3), strict=True)))
        now = rgb.traverse(bsdf)
        assert {key: str(now[key]) for key in keys} == before
        if plugin == "neural_layered":  # walks are random
            np.testing.assert_array_equal(probes.f(bsdf, *directions), f)
    parameters.update(dict(zip(keys, (0.3, 0.6, 0.3), strict=True)))
    assert [float(rgb.traverse(bsdf)[key][0]) for key in keys] == pytest.approx([0.3, 0.6, 0.3])
