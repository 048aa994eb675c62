"""Coats over bottoms known by their values alone, against tables and against the walk."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import f, strip

from urushi.mitsuba.reading import probing

SIGMA_T = (0.1, 0.4, 1.2)


def plugin(mi, bottom, **coat):
    """A coat of width 0.1, of an index of 1.5, over a plugin."""
    medium = {"sigma_t": {"type": "rgb", "value": list(SIGMA_T)}}
    interface = {"alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0}
    return mi.load_dict({"type": "neural_layered", **interface, **medium, **coat, "base": bottom})


def test_codes_of_textured_coats_are_near_the_table(rgb, merl_file, random_directions):
    texture = strip(0.2, 0.3, filter_type="nearest")
    bottom = {"type": "measured_brdf", "filename": str(merl_file)}
    wi, wo = random_directions(500, 1, 0.05), random_directions(500, 2, 0.05)
    found, expected = (f(plugin(rgb, bottom, alpha=x), wi, wo) for x in (texture, 0.2))
    assert np.abs(found - expected).mean() < 0.02 * expected.mean()


SLOW = pytest.mark.slow
TABULATED, TEXTURED, ANISOTROPIC = {"alpha": 0.1}, {"alpha": 0.2}, {"alpha_u": 0.05, "alpha_v": 0.3}


@pytest.mark.parametrize(
    ("bottom", "coat", "tolerance"),
    [
        ({"type": "principled", "clearcoat": 1.0, "clearcoat_gloss": 0.9}, TABULATED, 0.03),
        ({"type": "pplastic", "alpha": 0.1}, TEXTURED, 0.08),
        pytest.param({"type": "roughplastic", "alpha": 0.05}, TABULATED, 0.03, marks=SLOW),
        pytest.param(
            {"type": "openpbr", "specular_roughness": 0.15}, ANISOTROPIC, 0.08, marks=SLOW
        ),
    ],
)
def test_albedo_over_dielectrics_is_that_of_the_walk(rgb, bottom, coat, tolerance):
    """The standard error of the walk's albedo is below 0.5 %, and the table's error below 2 %; the
    networks, which layer textures and anisotropic coats, leave up to 7 % over dielectrics."""
    key = "base_color" if bottom["type"] in ("principled", "openpbr") else "diffuse_reflectance"
    color = {"type": "rgb", "value": [0.8, 0.35, 0.1]}
    if coat is TEXTURED:
        values = np.float32(color["value"])
        color = strip(0.9 * values, values, filter_type="nearest")
    bottom = {**bottom, key: color}
    count = 1 << 15
    u = np.random.default_rng(0).random((3, count), np.float32)
    wi = np.tile(np.float32([0.6, 0, 0.8]), (count, 1))
    si = probing.interaction(wi, np.full((count, 2), 0.75), np.arange(count))
    walk, neural = (
        rgb.load_dict({"type": kind, **coat, "base": bottom})
        for kind in ("layered", "neural_layered")
    )
    context = rgb.BSDFContext()
    sample, truth = walk.sample(context, si, rgb.Float(u[0]), rgb.Point2f(u[1:]))
    drawn = sample.pdf > 0
    weight = dr.select(drawn, neural.eval(context, si, sample.wo) / sample.pdf, 0)
    means = [np.array(value).mean(axis=1) for value in (weight, truth)]
    np.testing.assert_allclose(*means, rtol=tolerance)
