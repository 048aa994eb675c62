"""`urushi recipe`: a colour made of known paints is found again; colours in CIELAB; bad input."""

import numpy as np
import pytest

from urushi.app import recipe
from urushi.errors import ParameterError


def test_codes_are_read_and_written():
    assert recipe.linear("#ffffff") == pytest.approx([1, 1, 1])
    assert recipe.linear("bc0000") == pytest.approx([0.5, 0, 0], abs=0.005)
    for code in ("#7a2f1e", "#000000", "#0a0b0c"):
        assert recipe.code(recipe.linear(code)) == code
    for text in ("red", "#12345", "#12345g"):
        with pytest.raises(ParameterError, match=f"the colour is '{text}'; give an sRGB code such"):
            recipe.linear(text)


def test_distances_are_those_of_cielab():
    """Of sRGB's primaries as published for D65: white is L 100, red L 53.24, a 80.09, b 67.20."""
    white, black, red = np.ones(3), np.zeros(3), np.array([1.0, 0.0, 0.0])
    assert recipe.distance(white, black) == pytest.approx(100, abs=1e-6)
    expected = np.linalg.norm([53.24, 80.09, 67.20])
    assert recipe.distance(red, black) == pytest.approx(expected, abs=0.1)


def test_white_stays_white_through_the_surface():
    """A lossless white, and a black, have these colours from outside: exactly by reciprocity of the
    surface but for the angles of light and eye."""
    assert recipe.seen(np.array([0.0, 1.0])) == pytest.approx([0, 1], abs=0.06)


def test_a_ground_without_values_is_refused():
    with pytest.raises(ParameterError, match="reflectance has shape"):
        recipe.Recipe("#7a2f1e", ground=()).run()


@pytest.mark.slow
def test_a_mixture_is_found_again(capsys):
    """An opaque mixture's own colour: the walk agrees within 2.5, about the step of the parts."""
    from urushi.measured import pigments

    k, s = pigments.mixed(("titanium white", "cobalt blue"), np.array([[4, 1]]))
    color = recipe.code(recipe.seen(pigments.opaque(k / s))[0])
    recipe.Recipe(color, walks=1 << 14).run()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2
    assert min(float(line.split("dE ")[1].split(":")[0]) for line in lines) < 2.5
