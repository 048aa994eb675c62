"""Mitsuba's BSDFs as sources of `encode`: averages, parts that are left out, and errors."""

import warnings

import numpy as np
import pytest

from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError, PlatformError, UrushiWarning
from urushi.material.layer import layer
from urushi.material.source import as_source
from urushi.material.values import evaluate_source
from urushi.walk import analytic, conductor, dielectric

WI, WO = probe_pairs(64)


def test_an_isotropic_bsdf_is_read_unchanged(rgb):
    r0 = (0.9, 0.5, 0.2)
    source = rgb.load_dict({
        "type": "principled", "metallic": 1.0, "roughness": 0.5, "specular": 0.5,
        "base_color": {"type": "rgb", "value": r0},
    })  # fmt: skip
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        values, deviations = evaluate_source(source, WI, WO)
    assert not any(deviations[:-1]) and deviations.widths == 1
    exact = analytic.f(conductor(0.25, r0), WI, WO)  # its alpha is the roughness squared
    np.testing.assert_allclose(values, exact, rtol=0.02, atol=1e-4)


#: BSDFs, the share of diffuse light that is left out, its error, and a part of the warning.
LEFT_OUT = {
    # Onto glass of 1.5: 9.2 % come back (Walsh 1926); roughness loses a little.
    "transmitted": ({"type": "roughdielectric", "alpha": 0.3}, 0.915, 0.015, "lets 9"),
    "passed": ({"type": "mask", "opacity": 0.4, "n": {"type": "diffuse"}}, 0.6, 0.01, "lets 6"),
    "mirrored": (
        {"type": "plastic", "int_ior": 1.5, "ext_ior": 1.0},
        *(0.0918, 0.0015, "9% of the light by a perfectly smooth surface"),
    ),
}


@pytest.mark.parametrize("name", LEFT_OUT)
def test_transmission_and_smooth_reflection_are_left_out_with_a_warning(rgb, name):
    """Shares of 65,536 samples that vary by up to 100 %."""
    described, expected, error, sentence = LEFT_OUT[name]
    values, deviations = evaluate_source(rgb.load_dict(described), WI, WO)
    shares = [deviations.transmitted, deviations.mirrored]
    if name == "mirrored":
        shares.reverse()
    assert shares == [pytest.approx(expected, abs=error), 0]
    assert sentence in deviations.warnings()[0]
    if name == "passed":
        np.testing.assert_allclose(values, 0.4 * 0.5 / np.pi, rtol=1e-4)


ON_A_MESH = {"type": "mesh_attribute", "name": "vertex_color"}


@pytest.mark.parametrize(
    ("described", "sentence"),
    [
        ({"type": "conductor"}, "encode SmoothConductor: the BSDF is perfectly smooth"),
        ({"type": "dielectric"}, "is perfectly smooth, but a material must be rough"),
        ({"type": "null"}, "reflects nothing but only transmits"),
        (
            {"type": "principled", "base_color": ON_A_MESH},
            "Principled: the BSDF depends on a mesh attribute",
        ),
    ],
)
def test_bsdfs_without_rough_reflection_and_uv_are_refused(rgb, described, sentence):
    with pytest.raises(ParameterError, match=sentence):
        as_source(rgb.load_dict(described))


def test_a_texture_is_read_at_the_middle_of_uv(rgb):
    checks = {"type": "checkerboard", "color0": 0.2, "color1": 0.6}
    values, deviations = evaluate_source(
        rgb.load_dict({"type": "diffuse", "reflectance": checks}), WI, WO
    )
    assert deviations.textured
    assert "middle of uv" in deviations.warnings()[0]
    assert len(np.unique(values.round(6))) == 1


@pytest.mark.slow
def test_a_random_walk_is_averaged_without_a_warning(rgb):
    walk = {"type": "layered", "alpha": 0.3, "sigma_t": 1.0, "albedo": 0.8}
    walk = rgb.load_dict(walk | {"bottom": {"type": "diffuse"}})
    values, deviations = evaluate_source(walk, WI, WO)
    assert deviations.anisotropy is None and deviations.reciprocity is None
    swapped, _ = evaluate_source(walk, WO, WI)
    # 4,096 walks for each pair: only their noise of about 2 % remains.
    error = np.abs(values - swapped).sum() / swapped.sum()
    assert error < 0.05


def test_scalar_variants_are_refused(rgb):
    rgb.set_variant("scalar_rgb")
    with pytest.raises(PlatformError, match="cannot be read in the variant scalar_rgb"):
        as_source(rgb.load_dict({"type": "diffuse"}))


@pytest.mark.parametrize(
    "bottom",
    [
        {"type": "roughplastic", "alpha": 0.2},
        {"type": "roughconductor", "material": "Al", "alpha_u": 0.1, "alpha_v": 0.3},
    ],
    ids=lambda bottom: bottom["type"],
)
def test_a_coat_lies_over_the_same_codes_in_python_and_in_the_plugin(rgb, bottom):
    """For isotropic and for averaged bottoms both use one symmetrisation.

    What remains is the rounding of single precision in products of different shapes.
    """
    coated = rgb.load_dict(
        {"type": "neural_layered", "alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0, "base": bottom}
    )
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UrushiWarning)  # of the anisotropy
        expected = layer(dielectric(0.1, 1.5), rgb.load_dict(bottom))
    codes = coated.latents.at(np.full((1, 2), 0.5))[0]
    np.testing.assert_allclose(codes, expected.latents, atol=2e-6)
