"""After a change through `mi.traverse`, codes are those of a coat that is loaded anew."""

import numpy as np
import pytest
from tests.mitsuba import probes
from tests.mitsuba.probes import bitmap

from urushi.errors import ParameterError

SIDE = 16


def noise(channels: int, seed: int = 0) -> np.ndarray:
    """Numbers that are all different, from 0.1 to 0.9."""
    numbers = np.linspace(0.1, 0.9, SIDE * SIDE * channels)
    return np.random.default_rng(seed).permutation(numbers).reshape(SIDE, SIDE, channels)


def described(mi, networks, **properties) -> dict:
    return {
        "type": "neural_layered",
        "weights": str(networks),
        "alpha": 0.2,
        "albedo": bitmap(noise(3)),
        "sigma_t": 0.8,
        "base": {"type": "diffuse", "reflectance": bitmap(noise(3, 1))},
        **properties,
    }


def changed(mi, bsdf, **values) -> None:
    """Set parameters; names have "_" in place of "."."""
    parameters = mi.traverse(bsdf)
    for name, value in values.items():
        key = name.replace("_", ".").replace("sigma.t", "sigma_t")
        parameters[key] = value if np.ndim(value) == 0 else mi.TensorXf(np.float32(value))
    parameters.update()


def codes(bsdf) -> np.ndarray:
    """Codes at points that cover uv."""
    return bsdf.latents.at(np.random.default_rng(3).random((512, 2)))


def check_equal(bsdf, fresh) -> None:
    """Codes are equal up to what lies between nodes, which follow from the ranges of parameters."""
    found, expected = codes(bsdf), codes(fresh)
    assert np.abs(found - expected).max() <= np.ptp(expected) / 50


def test_changes_of_numbers_and_textures(rgb, networks):
    bsdf = rgb.load_dict(described(rgb, networks))
    narrow, wide = 0.2 + 0.6 * noise(3, 2), 1.2 * noise(3, 3) - 0.1
    larger = np.repeat(noise(3), 2, axis=0)
    base = {"type": "diffuse", "reflectance": bitmap(narrow)}
    for given, properties in (
        ({"sigma_t_value": 2.0}, {}),
        ({"albedo_data": narrow}, {"albedo": bitmap(narrow)}),
        ({"albedo_data": wide}, {"albedo": bitmap(wide)}),
        ({"albedo_data": larger, "bottom_reflectance_data": narrow}, {"base": base}),
    ):
        changed(rgb, bsdf, **given)
        if "bottom_reflectance_data" in given:
            properties["albedo"] = bitmap(larger)
        check_equal(bsdf, rgb.load_dict(described(rgb, networks, sigma_t=2.0, **properties)))


def test_changes_within_ranges_bake_nothing(rgb, networks, few_points):
    bsdf = rgb.load_dict(described(rgb, networks))
    baked = bsdf.latents.baked
    changed(rgb, bsdf, albedo_data=noise(3))
    changed(rgb, bsdf, albedo_data=0.2 + 0.6 * noise(3), bottom_reflectance_data=noise(3, 2))
    assert bsdf.latents.baked is baked
    changed(rgb, bsdf, sigma_t_value=2.0)
    assert bsdf.latents.baked is not baked


def test_a_constant_of_a_textured_bottom(rgb, networks, few_points):
    base = {"type": "roughconductor", "alpha": bitmap(noise(1)), "distribution": "beckmann"}
    bsdf = rgb.load_dict(described(rgb, networks, albedo=0.5, base=base))
    changed(rgb, bsdf, bottom_eta_value=0.5)
    base |= {"eta": 0.5, "k": 1.0}
    check_equal(bsdf, rgb.load_dict(described(rgb, networks, albedo=0.5, base=base)))


def test_a_change_of_a_nested_coat(rgb, networks, few_points):
    inner = described(rgb, networks)
    outer = {"type": "neural_layered", "weights": str(networks), "alpha": 0.1, "inner": inner}
    bsdf = rgb.load_dict(outer)
    pixels = noise(3)
    pixels[0, 0] = 0.95
    changed(rgb, bsdf, bottom_albedo_data=pixels)
    inner["albedo"] = bitmap(pixels)
    check_equal(bsdf, rgb.load_dict(outer))


def test_a_change_out_of_range_can_be_taken_back(rgb, networks, few_points):
    bsdf = rgb.load_dict(described(rgb, networks))
    before = codes(bsdf)
    with pytest.raises(ParameterError, match="albedo is .*; it must be"):
        changed(rgb, bsdf, albedo_data=noise(3) + 1)
    changed(rgb, bsdf, albedo_data=noise(3))
    np.testing.assert_array_equal(codes(bsdf), before)


def test_a_bitmap_of_four_channels_is_refused(rgb, networks, few_points):
    """Mitsuba would read beyond its end and end the process; it cannot take the bitmap back."""
    bsdf = rgb.load_dict(described(rgb, networks))
    with pytest.raises((ParameterError, RuntimeError), match="changed to .*4 channels"):
        changed(rgb, bsdf, albedo_data=noise(4))


@pytest.mark.parametrize("plugin", ("neural_layered", "layered"))
def test_a_refused_change_leaves_all_coats_as_they_were(rgb, networks, plugin):
    """Of two nested coats and their bottom, whichever is refused, in a wrapper."""

    def coat(below, **properties) -> dict:
        return {"type": plugin, "weights": str(networks), "alpha": 0.2, "on": below, **properties}

    inner = coat({"type": "diffuse"}, albedo=0.5, sigma_t=1.0)
    bsdf = rgb.load_dict(coat({"type": "twosided", "front": inner}, sigma_t=0.1))
    parameters, directions = rgb.traverse(bsdf), probes.pairs(64)
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
