"""Baking of coats without a renderer: equal to layering every texel, but only of distinct rows."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.material.layer import layer_texels
from urushi.textures import bake
from urushi.textures.bake import BakedTexture, coat_source
from urushi.textures.store import TexelGrid

GRID = TexelGrid(6, 4)


@pytest.fixture
def layered_rows(monkeypatch):
    """The number of rows of each call of `layer_texels`; the network layers few rows too."""
    monkeypatch.setattr(bake, "FEW", {1: 0, 2: 0})
    counts = []

    def counted(model, z, coat):
        counts.append(z[..., 0].size)
        return layer_texels(model, z, coat)

    monkeypatch.setattr(bake, "layer_texels", counted)
    return counts


def test_only_distinct_and_changed_rows_are_layered(model, layered_rows):
    rng = np.random.default_rng(0)
    codes = 0.2 * rng.normal(size=(1, 3, model.arch.latent)).astype(np.float32)
    codes[..., :6] = [0.2, 0, 0, 1, 1.5, 0]
    hashes = bake.code_hashes(codes)
    coat = {"alpha": 0.1, "eta": 1.5, "albedo": 0.5, "sigma_t": 1.0, "g": 0.0}
    parameters = {name: np.full((24, 1), value) for name, value in coat.items()}
    parameters["alpha"][:12] = 0.3

    def table(start, stop):
        return CoatParameters(**{n: values[start:stop] for n, values in parameters.items()})

    def bottom(start, stop):
        return hashes, lambda texel, channel: codes[0, channel]

    texture = BakedTexture(model, GRID, 3)
    texture.update(coat_source(model, table, bottom))
    assert layered_rows == [6]  # two values of alpha, three channels
    texture.update(coat_source(model, table, bottom))
    assert layered_rows == [6]
    parameters["alpha"][5] = 0.2
    texture.update(coat_source(model, table, bottom))
    assert layered_rows == [6, 3]
    expected = layer_texels(model, codes, CoatParameters(**parameters))
    found = texture.store.read(slice(None))
    # 8 bits of a number's range and half precision
    np.testing.assert_allclose(found, expected, atol=0.02 * np.ptp(expected))


def test_texels_that_share_nothing_equal_those_that_share(model, layered_rows, monkeypatch):
    rng = np.random.default_rng(1)
    codes = 0.2 * rng.normal(size=(24, 3, model.arch.latent)).astype(np.float32)
    codes[..., :6] = [0.2, 0, 0, 1, 1.5, 0]
    codes[1] = codes[0]
    hashes = bake.code_hashes(codes)
    coat = {
        "alpha": rng.uniform(0.1, 0.5, (24, 1)),
        "eta": np.full((24, 1), 1.5),
        "albedo": rng.uniform(0, 1, (24, 3)),
        "sigma_t": rng.uniform(0, 2, (24, 3)),
        "g": rng.uniform(-0.5, 0.5, (24, 1)),
    }

    def table(start, stop):
        return CoatParameters(**{name: values[start:stop] for name, values in coat.items()})

    def bottom(start, stop):
        return hashes[start:stop], lambda texel, channel: codes[start:stop][texel, channel]

    def baked():
        texture = BakedTexture(model, TexelGrid(24, 1), 3)
        texture.update(coat_source(model, table, bottom))
        return texture.store.read(slice(None))

    different = baked()
    for values in coat.values():
        values[1] = values[0]
    shared = baked()
    assert layered_rows == [72, 69]
    # Rows of equal hashes are computed once in all blocks.
    monkeypatch.setattr(bake, "TEXEL_BLOCK", 7)
    for values in coat.values():
        values[20] = values[2]
    codes[20], hashes[20] = codes[2], hashes[2]
    blocks = baked()
    assert sum(layered_rows[2:]) == 66
    np.testing.assert_allclose(blocks[:20], shared[:20], atol=0.01 * np.ptp(different))
    np.testing.assert_array_equal(blocks[20], blocks[2])
    kept = np.delete(np.arange(24), 1)
    # 8 bits of the range of the texture
    np.testing.assert_allclose(shared[kept], different[kept], atol=0.01 * np.ptp(different))
    np.testing.assert_array_equal(shared[0], shared[1])
    # Grey texels: one row for each, given as three channels.
    for name in ("albedo", "sigma_t"):
        coat[name][:] = coat[name][:, :1]
    codes[:], hashes[:] = codes[:, :1], hashes[:, :1]
    monkeypatch.setattr(bake, "TEXEL_BLOCK", 24)
    grey = baked()
    assert layered_rows[-1] == 22
    np.testing.assert_array_equal(grey[:, 0], grey[:, 2])


def test_only_equal_rows_have_equal_hashes():
    rng = np.random.default_rng(1)
    columns = [rng.integers(4, size=3000).astype(np.float32) for _ in range(4)]
    found = bake.row_hashes(columns)
    rows = {tuple(row) for row in np.stack(columns, axis=1).tolist()}
    assert len(np.unique(found)) == len(rows)
    again = bake.row_hashes(
        [column * np.float32(1 + 1e-6) for column in columns]
    )  # with the rounding errors of a filter
    np.testing.assert_array_equal(again, found)
    assert (bake.row_hashes(columns[::-1]) != found).any()
