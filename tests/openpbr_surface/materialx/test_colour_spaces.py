"""Colour spaces: white stays white, and matrices against those of MaterialX's own library."""

from pathlib import Path

import numpy as np
import pytest

from urushi.errors import FileError
from urushi.openpbr_surface.materialx.colour_spaces import (
    ALIASES,
    SPACES,
    matrix_to_srgb,
    to_linear_srgb,
)


@pytest.mark.parametrize("space", SPACES)
def test_white_and_black_stay(space):
    """A space's white is sRGB's, by the adaptation; exact but for rounding."""
    colours = to_linear_srgb([[1, 1, 1], [0, 0, 0]], space, "x")
    assert np.allclose(colours, [[1, 1, 1], [0, 0, 0]], atol=1e-6)


@pytest.mark.parametrize(
    ("space", "tolerance"), [("acescg", 1e-9), ("lin_adobergb", 1e-8), ("lin_displayp3", 2e-5)]
)
def test_matrices_are_those_of_materialx(package, space, tolerance):
    """The library's matrix of Display P3 is from rounded white points, hence the tolerance."""
    file = Path(package.__file__).parent / "libraries" / "cmlib" / "cmlib_ng.mtlx"
    package.readFromXmlFile(root := package.createDocument(), str(file))
    graph = root.getNodeGraph(f"NG_{space}_to_lin_rec709_color3")
    text = graph.getNodes("constant")[0].getInput("value").getValueString()
    columns = np.array([float(x) for x in text.split(",")]).reshape(3, 3)
    assert np.allclose(matrix_to_srgb(SPACES[space].primaries), columns.T, atol=tolerance)


def test_srgb_is_decoded_as_in_its_standard():
    decoded = to_linear_srgb([0.5, 0.02, 1.0, 0.3], "srgb_texture", "x")
    assert np.allclose(decoded, [((0.5 + 0.055) / 1.055) ** 2.4, 0.02 / 12.92, 1, 0.3])


def test_the_fourth_channel_is_not_a_colour():
    assert to_linear_srgb([0.2, 0.4, 0.6, 0.5], "acescg", "x")[3] == 0.5


@pytest.mark.parametrize(
    ("name", "space"),
    [
        ("sRGB", "srgb_texture"),
        ("Utility - sRGB - Texture", "srgb_texture"),
        ("gamma22", "g22_rec709"),
        ("Linear Rec.709 (sRGB)", "lin_rec709"),
        ("ACES - ACEScg", "acescg"),
        ("lin_ap1_scene", "acescg"),
        ("Raw", "none"),
        ("Utility - Raw", "none"),
    ],
)
def test_names_of_exporters(name, space):
    colours = np.random.default_rng(0).random((5, 3))
    assert np.array_equal(to_linear_srgb(colours, name, "x"), to_linear_srgb(colours, space, "x"))


def test_aliases_name_spaces():
    assert ALIASES.keys() <= SPACES.keys()


def test_an_unknown_space_is_refused():
    with pytest.raises(FileError, match="x: the colour space 'bt2100' is unknown; use one of srgb"):
        to_linear_srgb([1, 1, 1], "bt2100", "x")
