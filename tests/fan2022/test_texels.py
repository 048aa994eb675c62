"""Grids, averages and comparisons of what textures of the paper's codes are made of."""

import numpy as np
import pytest

from urushi.errors import ParameterError
from urushi.textures.store import ONE_TEXEL, TexelGrid


def test_the_grid_resolves_all_textures_over_uv(rgb):
    from fan2022.texels import choose

    def bitmap(height, width, *factors):
        pixels = np.random.default_rng(0).random((height, width, 1), np.float32)
        place = rgb.ScalarTransform3f(np.diag(np.float32([*factors, 1])))
        return rgb.load_dict(
            {"type": "bitmap", "bitmap": rgb.Bitmap(pixels), "raw": True, "to_uv": place}
        )

    parts = {"alpha": bitmap(4, 6, 3, 1), "albedo": bitmap(5, 2, 1, 2)}
    assert choose(parts, ONE_TEXEL, 0, "test") == TexelGrid(18, 10)
    assert choose(parts, TexelGrid(30, 4), 0, "test") == TexelGrid(30, 10)
    assert choose(parts, ONE_TEXEL, 9, "test") == TexelGrid(9, 9)
    constant = rgb.load_dict({"type": "uniform", "value": 0.5})
    assert choose({"alpha": constant}, ONE_TEXEL, 9, "test") == ONE_TEXEL
    attribute = rgb.load_dict({"type": "mesh_attribute", "name": "vertex_color"})
    with pytest.raises(ParameterError, match="depends on a mesh attribute"):
        choose({"albedo": attribute}, ONE_TEXEL, 0, "test")


@pytest.mark.parametrize(("width", "height"), [(8, 4), (7, 5), (5, 1), (1, 6)])
def test_every_level_keeps_the_average(rgb, width, height):
    from fan2022.texels import half_resolution

    values = np.random.default_rng(1).random((height, width, 2)).astype(np.float32)
    mean = values.mean(axis=(0, 1))
    while values.shape != (1, 1, 2):
        sides = [max(side // 2, 1) for side in values.shape[:2]]
        values = half_resolution(values)
        assert values.shape == (*sides, 2)
        np.testing.assert_allclose(values.mean(axis=(0, 1)), mean, rtol=1e-5)
