"""The grid of texels follows the textures."""

import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.textures.store import IDENTITY, TexelGrid


def bitmap(mi, height, width, **properties):
    pixels = np.random.default_rng(0).random((height, width, 1), np.float32)
    return mi.load_dict({"type": "bitmap", "bitmap": mi.Bitmap(pixels), "raw": True, **properties})


def scaled(mi, *factors):
    return mi.ScalarTransform3f(np.diag(np.float32([*factors, 1])))


@pytest.mark.parametrize("wrap", ["repeat", "mirror", "clamp"])
@pytest.mark.parametrize("filter_type", ["bilinear", "nearest"])
def test_one_texture_gives_its_own_space(rgb, wrap, filter_type):
    from urushi.fan2022.grid import choose

    shear = np.float32([[1.5, 0.25, 0.1], [-0.5, 2.25, 0.25], [0, 0, 1]])
    properties = {"wrap_mode": wrap, "filter_type": filter_type}
    texture = bitmap(rgb, 4, 6, to_uv=rgb.ScalarTransform3f(shear), **properties)
    chosen = choose({"alpha": texture}, None, 0, "test")
    place = tuple(tuple(row) for row in shear[:2].tolist())
    assert chosen == TexelGrid(6, 4, place, wrap, filter_type == "nearest")
    assert choose({"alpha": texture}, None, 9, "test")[:2] == (9, 9)


def test_textures_of_different_spaces_are_resolved_over_uv(rgb):
    from urushi.fan2022.grid import choose

    parts = {
        "alpha": bitmap(rgb, 4, 6, to_uv=scaled(rgb, 3, 1)),
        "albedo": bitmap(rgb, 5, 2, to_uv=scaled(rgb, 1, 2)),
    }
    assert choose(parts, None, 0, "test") == TexelGrid(18, 10, IDENTITY, "repeat", False)


def test_constants_have_no_grid_and_mesh_attributes_are_refused(rgb):
    from urushi.fan2022.grid import choose

    constant = rgb.load_dict({"type": "uniform", "value": 0.5})
    assert choose({"alpha": constant}, None, 0, "test") is None
    attribute = rgb.load_dict({"type": "mesh_attribute", "name": "vertex_color"})
    with pytest.raises(ParameterError, match="depends on a mesh attribute"):
        choose({"albedo": attribute}, None, 0, "test")
