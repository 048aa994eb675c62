"""Colour spaces: white stays white, matrices against MaterialX's library and standards, names."""

from pathlib import Path

import numpy as np
import pytest

from urushi.errors import FileError
from urushi.openpbr_surface.materialx.colour_spaces import ALIASES, spaces, to_linear_srgb

#: MaterialX's own names of spaces.
NAMES = (
    "srgb_texture lin_rec709 g18_rec709 g22_rec709 rec709_display acescg g22_ap1 aces2065_1 "
    "adobergb lin_adobergb srgb_displayp3 lin_displayp3"
)


def matrix_of(space):
    """The matrix (3, 3) of a linear space; its columns are its primaries in linear sRGB."""
    return to_linear_srgb(np.eye(3), space, "x").T


@pytest.mark.parametrize("space", [*NAMES.split(), "lin_rec2020_scene", "srgb_ap1_scene"])
def test_white_and_black_stay(space):
    """A space's white is sRGB's, by the adaptation; OpenColorIO's powers are within 5e-5."""
    colours = to_linear_srgb([[1, 1, 1], [0, 0, 0]], space, "x")
    assert np.allclose(colours, [[1, 1, 1], [0, 0, 0]], atol=5e-5)


@pytest.mark.parametrize(
    ("space", "tolerance"), [("acescg", 1e-6), ("lin_adobergb", 1e-6), ("lin_displayp3", 2e-5)]
)
def test_matrices_are_those_of_materialx(package, space, tolerance):
    """The library's matrix of Display P3 is from rounded white points, hence the tolerance."""
    file = Path(package.__file__).parent / "libraries" / "cmlib" / "cmlib_ng.mtlx"
    package.readFromXmlFile(root := package.createDocument(), str(file))
    graph = root.getNodeGraph(f"NG_{space}_to_lin_rec709_color3")
    text = graph.getNodes("constant")[0].getInput("value").getValueString()
    columns = np.array([float(x) for x in text.split(",")]).reshape(3, 3)
    assert np.allclose(matrix_of(space), columns.T, atol=tolerance)


def test_the_matrix_of_rec2020_is_that_of_its_standard():
    """ITU-R BT.2087, the inverse of its matrix of BT.709 in BT.2020, which has four digits."""
    matrix = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]]
    assert np.allclose(matrix @ matrix_of("lin_rec2020_scene"), np.eye(3), atol=3e-4)


def test_encoded_values_are_decoded_as_in_their_standards():
    """IEC 61966-2-1, and a power. A fourth channel is no colour and stays."""
    decoded = to_linear_srgb([0.5, 0.02, 1.0, 0.3], "srgb_texture", "x")
    assert np.allclose(decoded, [((0.5 + 0.055) / 1.055) ** 2.4, 0.02 / 12.92, 1, 0.3], atol=5e-5)
    encoded = to_linear_srgb([0.5, 0.02, 1.0], "srgb_ap1_scene", "x")
    linear = to_linear_srgb(decoded[:3], "acescg", "x")
    assert np.allclose(encoded, linear, atol=1e-4)
    assert np.allclose(to_linear_srgb([0.5, 0.2, 0.1], "g22_rec709", "x")[0], 0.5**2.2, atol=5e-5)


@pytest.mark.parametrize(
    ("name", "space"),
    [
        ("sRGB", "srgb_texture"),
        ("srgb_tx", "srgb_texture"),
        ("Utility - sRGB - Texture", "srgb_texture"),
        ("gamma22", "g22_rec709"),
        ("Linear Rec.709 (sRGB)", "lin_rec709"),
        ("ACES - ACEScg", "acescg"),
        ("lin_ap1_scene", "acescg"),
        ("Linear Rec.2020", "lin_rec2020_scene"),
        ("Raw", "none"),
        ("Utility - Raw", "none"),
    ],
)
def test_names_of_exporters(name, space):
    colours = np.random.default_rng(0).random((5, 3))
    assert np.array_equal(to_linear_srgb(colours, name, "x"), to_linear_srgb(colours, space, "x"))


def test_aliases_name_spaces():
    assert ALIASES.keys() <= set(spaces().values())


def test_an_unknown_space_is_refused():
    with pytest.raises(FileError, match="x: the colour space 'bt2100' is unknown; use one of Open"):
        to_linear_srgb([1, 1, 1], "bt2100", "x")
