"""Measured paints: closed forms, the walk, another laboratory's measurement, bad input."""

import numpy as np
import pytest

import urushi
from urushi.errors import ParameterError
from urushi.measured import pigments
from urushi.walk.simulate import albedo

WHITE = "titanium white"

#: Golden's pyrrole red 1277, opaque over white, gloss included, by its maker (Glassner and Haines
#: 2014, realtimerendering.com/golden.html): wavelengths [nm] and reflectance.
MADE = np.array([400, 430, 460, 490, 520, 550, 580, 610, 640, 670, 700])
RED = [0.0414, 0.0405, 0.0415, 0.0415, 0.0416, 0.0427, 0.0492, 0.452, 0.7572, 0.8384, 0.8786]


def test_pyrrole_red_is_what_its_maker_measured():
    """Within 0.05, the difference of two instruments and films; the edge at 600 nm is steep."""
    k, s = pigments.paints()["pyrrole red"]
    inside = pigments.opaque(k / s)
    outside = 0.03 + 0.97 * 0.35 * inside / (1 - 0.65 * inside)  # Saunderson, as in Berns 2016
    found = np.interp(MADE, pigments.WAVELENGTHS, outside)
    assert np.abs(found - RED).max() < 0.05


def test_films_end_at_ground_and_paint():
    k, s, ground = np.full(3, 0.5), np.full(3, 2.0), np.array([0.0, 0.4, 1.0])
    np.testing.assert_allclose(pigments.over(1e-6 * k, 1e-6 * s, ground), ground, atol=1e-5)
    np.testing.assert_allclose(pigments.over(50 * k, 50 * s, ground), pigments.opaque(k / s))


@pytest.mark.parametrize(
    "parts", ({WHITE: 1}, {"pyrrole red": 1}, {WHITE: 9, "cobalt blue": 1, "bone black": 1})
)
@pytest.mark.parametrize("thickness", (1.0, 20.0))
def test_media_reflect_diffuse_light_as_films_of_kubelka_and_munk(parts, thickness):
    """Without an interface, over a ground of 0.5: the two fluxes are within 0.03 of transport."""
    stack = urushi.coat(urushi.diffuse(0.5), eta=1.0, **urushi.pigment(parts), thickness=thickness)
    nodes, weights = np.polynomial.legendre.leggauss(4)
    cosines = 0.5 * (nodes + 1)
    wi = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
    found, _ = albedo(stack, wi, walks=4096, seed=3)
    k, s = pigments.mixed(parts, np.array([list(parts.values())]))
    expected = pigments.over(thickness * k[0], thickness * s[0], np.full(3, 0.5))
    np.testing.assert_allclose((weights * cosines) @ found, expected, atol=0.03)


def test_a_mixture_does_not_depend_on_the_unit_of_its_parts():
    one, ten = (urushi.pigment({WHITE: 3 * x, "bone black": x}) for x in (1, 10))
    for name in one:
        assert one[name] == pytest.approx(ten[name])
    assert urushi.pigment(WHITE) == urushi.pigment({WHITE: 2.0, "bone black": 0.0})


@pytest.mark.parametrize(
    ("paint", "sentence"),
    [
        ("vermilion", "no paint is named 'vermilion'; the paints are bismuth vanadate yellow, "),
        ({WHITE: 0}, "the parts of a mixture are {'titanium white': 0}; give numbers above 0"),
        ({WHITE: 1, "bone black": -1}, "give numbers above 0"),
        ({}, "give numbers above 0"),
        ({WHITE: "x"}, "give numbers above 0"),
        (None, "paint is None; give a name, or a dictionary of parts by name"),
    ],
)
def test_bad_input_is_named(paint, sentence):
    with pytest.raises(ParameterError) as caught:
        urushi.pigment(paint)
    assert sentence in str(caught.value)
