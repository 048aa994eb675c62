"""Textured parameters and textured bottoms."""

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.mitsuba.probes import bitmap, f, nearly, strip

from urushi.core.appearance import LOOK
from urushi.nets.weights import default_model

COAT = {"alpha": 0.2, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}


def load(mi, name, networks, **properties):
    extra = {} if name == "layered" else {"weights": str(networks)}
    base = {"type": "diffuse", "reflectance": properties.pop("reflectance", 0.5)}
    coat = COAT if not LOOK.keys() & properties.keys() else {"alpha": 0.2, "g": 0.3, "body": 0.5}
    return mi.load_dict({"type": name, "base": base, **extra, **coat, **properties})


def mean_and_error(bsdf, uv) -> tuple[np.ndarray, np.ndarray]:
    """f averaged over directions, at a point, and its standard error."""
    wi, wo = pairs_above(1 << 12, 0, 0.2)
    value = f(bsdf, wi, wo, uv)
    return value.mean(axis=0), value.std(axis=0) / len(wi) ** 0.5


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
@pytest.mark.parametrize(
    "parameter",
    [
        "alpha", "albedo", "sigma_t", "g", "int_ior", "thickness", "color", "body", "body_color",
        "reflectance",
    ],
)  # fmt: skip
def test_every_texel_is_layered_with_its_own_parameters(rgb, networks, few_points, name, parameter):
    values = np.float32([[0.2, 0.4, 0.6], [0.5, 0.8, 0.3]]) + (parameter == "int_ior")
    texture = bitmap(values[..., None], filter_type="nearest")
    textured, shown = load(rgb, name, networks, **{parameter: texture}), rgb.load_dict(texture)
    for row, column in ((0, 0), (1, 2)):
        si = rgb.SurfaceInteraction3f()
        # Mitsuba's bitmaps have v upwards: the first row is at the top
        si.uv = uv = ((column + 0.5) / 3, (row + 0.5) / 2)
        value = float(shown.eval_1(si)[0])
        value = value if name == "layered" else nearly(value)  # codes, not a table
        (a, error_a), (b, error_b) = (
            mean_and_error(bsdf, uv)
            for bsdf in (load(rgb, name, networks, **{parameter: value}), textured)
        )
        noise = 5 * np.hypot(error_a, error_b) if name == "layered" else 1e-2 * a
        assert (np.abs(a - b) <= noise).all(), (row, column)


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
def test_dark_texels_of_a_width_are_the_least_width(rgb, networks, few_points, name):
    """A roughness map may have black texels, also all of them beside another texture, though it
    then counts as a number; the constant 0 and texels above 1 are refused."""
    dark, other = strip(0.0, 0.3), {"albedo": strip(0.2, 0.7)}
    for black, least, more in ((dark, strip(0.01, 0.3), {}), (strip(0.0, 0.0), 0.01, other)):
        found, expected = (
            mean_and_error(load(rgb, name, networks, alpha=x, **more), (0.25, 0.5))[0]
            for x in (black, least)
        )
        np.testing.assert_allclose(found, expected, rtol=1e-5)
    with pytest.raises(RuntimeError, match="alpha is 0; it must be"):
        load(rgb, name, networks, alpha=0.0)
    with pytest.raises(RuntimeError, match="a texel of alpha is 1.3; it must be"):
        load(rgb, name, networks, alpha=strip(1.0, 1.3))


def test_dark_texels_of_a_nested_metal_are_the_least_width(rgb, few_points):
    """As the constant below it, which Mitsuba accepts."""

    def coat(width):
        metal = {"type": "roughconductor", "distribution": "ggx", "alpha": strip(width, 0.3)}
        return rgb.load_dict({"type": "neural_layered", "base": metal})

    black, least = (mean_and_error(coat(width), (0.25, 0.5)) for width in (0.001, 0.01))
    np.testing.assert_array_equal(black[0], least[0])


def test_isotropic_networks_take_the_mean_of_a_brushed_bottom(rgb):
    """As of a constant one, within 5 %; only few azimuths contribute to the light of a narrow
    lobe, and a constant bottom has a table."""
    wi, wo = default_model().networks.pairs()
    values = []
    for value in (float, nearly):
        widths = {"alpha_u": value(0.03), "alpha_v": value(0.5)}
        brushed = {"type": "roughconductor", "distribution": "ggx", **widths}
        coat = {"type": "neural_layered", "weights": "default", "bottom": brushed, **COAT}
        values.append(f(rgb.load_dict(coat), wi, wo, (0.5, 0.5)) * (wi[:, 2:] * wo[:, 2:]))
    expected, found = values
    assert np.abs(found - expected).sum() < 0.05 * expected.sum()


@pytest.mark.parametrize(
    "brushed",
    [
        {"type": "principled", "metallic": 1.0, "anisotropic": strip(0.8, 0.0, 0.8)},
        {"type": "roughconductor", "distribution": "beckmann", "alpha_v": 0.3}
        | {"alpha_u": strip(0.1, 0.3, 0.3)},
    ],
    ids=lambda brushed: brushed["type"],
)
def test_a_bottom_may_be_brushed_away_from_the_middle_of_uv(rgb, few_points, brushed):
    """There it reflects otherwise along u than along v; in the middle it does not."""
    coat = rgb.load_dict({"type": "neural_layered", "base": brushed})
    wi, wo = pairs_above(1 << 12, 0, 0.2)
    turn = np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]], np.float32)
    errors = []
    for u in (1 / 6, 0.5):
        one, other = f(coat, wi, wo, (u, 0.5)), f(coat, wi @ turn, wo @ turn, (u, 0.5))
        errors.append(np.abs(one - other).mean() / one.mean())
    assert errors[0] > 0.3 and errors[1] < 0.05


@pytest.mark.parametrize(
    "properties",
    [
        {"filter_type": "bilinear", "wrap_mode": "repeat"},
        {"filter_type": "nearest", "wrap_mode": "mirror"},
        {"filter_type": "bilinear", "wrap_mode": "clamp"},
        {"type": "checkerboard", "color0": 0.2, "color1": 0.9},
    ],
)
def test_a_parameter_has_the_values_of_its_texture(rgb, networks, few_points, properties):
    """f is that of a coat whose texture has the same values elsewhere, along a line."""
    shear = rgb.ScalarTransform3f(np.float32([[1.5, 0.25, 0.1], [-0.5, 2.2, 0.3], [0, 0, 1]]))
    rng = np.random.default_rng(0)
    described = properties if "type" in properties else bitmap(rng.random((4, 6, 1)))
    texture = rgb.load_dict(described | properties | {"to_uv": shear})
    uv = rng.uniform(-2, 3, (256, 2))
    si = rgb.SurfaceInteraction3f()
    si.uv = rgb.Point2f(np.float32(uv).T)
    values = texture.eval(si)[0].numpy()
    data = rgb.traverse(texture)["data"].numpy() if "type" not in properties else (0.2, 0.9)
    low, high = np.min(data), np.max(data)
    line = bitmap(np.float32([low, high]).reshape(1, 2, 1), wrap_mode="clamp")
    places = 0.25 + 0.5 * (values - low) / (high - low)  # the centres of the line's two texels
    wi, wo = (np.tile(w, (len(uv), 1)) for w in ([0.6, 0, 0.8], [0, 0.28, 0.96]))
    found, expected = (
        f(load(rgb, "neural_layered", networks, albedo=albedo), wi, wo, at)
        for albedo, at in ((texture, uv), (line, np.stack([places, 0 * places], axis=-1)))
    )
    np.testing.assert_allclose(found, expected, rtol=1e-3)


def test_a_width_on_a_mesh_has_all_values_near_the_other_one(rgb):
    """Codes have ratios of widths up to 10."""
    from urushi.mitsuba.reading.parameters import CoatTextures
    from urushi.mitsuba.reading.varying import varying_parameters

    on_mesh = {"type": "mesh_attribute", "name": "vertex_width"}
    bottom = {"type": "roughconductor", "alpha_u": on_mesh, "alpha_v": 0.02}
    props = rgb.Properties("neural_layered")
    props["alpha_u"], props["alpha_v"] = rgb.load_dict(on_mesh), 0.25
    found = varying_parameters(CoatTextures(props), rgb.load_dict(bottom))
    ranges = {x.axis.name: (x.axis.least, x.axis.most) for x in found}
    assert ranges["alpha_u"] == pytest.approx((0.025, 1))
    assert ranges["bottom.alpha_u"] == pytest.approx((0.01, 0.2))


def test_texels_of_files_follow_the_textures(rgb):
    """A bitmap's texels have a whole number of them, at least 64 a side; constants do not count."""
    from urushi.mitsuba.reading.layer_codes import grid_of

    small = rgb.load_dict(bitmap(np.random.default_rng(0).random((3, 5, 1))))
    uniform = rgb.load_dict({"type": "uniform", "value": 0.5})
    width, height = grid_of([small, uniform], 0)[:2]
    assert width % 5 == height % 3 == 0
    assert 64 <= width < 64 + 5 and 64 <= height < 64 + 3
    board = rgb.load_dict({"type": "checkerboard"})
    width, height = grid_of([small, board], 0)[:2]
    assert width == height > 128
    assert grid_of([small, board], 32)[:2] == (32, 32)
