"""Baking of coats without a renderer: equal to layering every texel, but only of distinct rows."""

import numpy as np
import pytest

from urushi.material.layer import layer_texels
from urushi.textures import bake, texel_hash
from urushi.textures.bake import CoatTexture
from urushi.textures.grid import TexelGrid

GRID = TexelGrid(6, 4)


@pytest.fixture
def layered_rows(monkeypatch):
    """The number of rows of each call of `layer_texels`."""
    counts = []

    def counted(model, z, **table):
        counts.append(len(z))
        return layer_texels(model, z, **table)

    monkeypatch.setattr(bake, "layer_texels", counted)
    return counts


def test_only_distinct_and_changed_rows_are_layered(model, layered_rows):
    rng = np.random.default_rng(0)
    codes = rng.normal(size=(1, 3, 32)).astype(np.float32)
    codes[..., :6] = [0.2, 0, 0, 1, 1.5, 0]
    hashes = texel_hash.row_hashes(list(np.moveaxis(codes, -1, 0)))
    coat = {"alpha": 0.1, "eta": 1.5, "albedo": 0.5, "sigma_t": 1.0, "g": 0.0}
    parameters = {name: np.full((24, 1), value) for name, value in coat.items()}
    parameters["alpha"][:12] = 0.3

    def table(start, stop):
        return {name: values[start:stop] for name, values in parameters.items()}

    def bottom(start, stop):
        return hashes, codes

    texture = CoatTexture(model, GRID, 3, mipmaps=False)
    texture.update(table, bottom)
    assert layered_rows == [6]  # two values of alpha, three channels
    texture.update(table, bottom)
    assert layered_rows == [6]
    parameters["alpha"][5] = 0.2
    texture.update(table, bottom)
    assert layered_rows == [6, 3]
    expected = layer_texels(model, codes, **parameters)
    found = texture.store.read(slice(None))
    # 8 bits of a number's range and half precision
    np.testing.assert_allclose(found, expected, atol=0.02 * np.ptp(expected))
