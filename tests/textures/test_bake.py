"""Baking of coats without a renderer: equal to layering every texel, but only of distinct rows."""

import numpy as np
import pytest

from urushi.checks import CoatParameters
from urushi.material.layer import layer_texels
from urushi.textures import bake
from urushi.textures.bake import BakedTexture, coat_source
from urushi.textures.layering import TRANSPORTED, layer_rows, transported
from urushi.textures.store import TexelGrid

GRID = TexelGrid(6, 4)


@pytest.fixture
def layered_rows(model):
    """The number of rows of each layering, which is by the network alone, and its function."""
    counts = []

    def codes_of(rows):
        counts.append(len(rows))
        z, columns = rows[:, : model.arch.latent], rows[:, model.arch.latent :]
        return layer_texels(model, z, CoatParameters.of_columns([*columns.T]))

    return counts, codes_of


def test_only_distinct_and_changed_rows_are_layered(model, layered_rows):
    counts, codes_of = layered_rows
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
    texture.update(coat_source(table, bottom), codes_of=codes_of)
    assert counts == [6]  # two values of alpha, three channels
    texture.update(coat_source(table, bottom), codes_of=codes_of)
    assert counts == [6]
    parameters["alpha"][5] = 0.2
    texture.update(coat_source(table, bottom), codes_of=codes_of)
    assert counts == [6, 3]
    expected = layer_texels(model, codes, CoatParameters(**parameters))
    found = texture.store.read(slice(None))
    # 8 bits of a number's range and half precision
    np.testing.assert_allclose(found, expected, atol=0.02 * np.ptp(expected))


def test_texels_that_share_nothing_equal_those_that_share(model, layered_rows, monkeypatch):
    counts, codes_of = layered_rows
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
        texture.update(coat_source(table, bottom), codes_of=codes_of)
        return texture.store.read(slice(None))

    different = baked()
    for values in coat.values():
        values[1] = values[0]
    shared = baked()
    assert counts == [72, 69]
    # Rows of equal hashes are computed once in all blocks.
    monkeypatch.setattr(bake, "TEXEL_BLOCK", 7)
    for values in coat.values():
        values[20] = values[2]
    codes[20], hashes[20] = codes[2], hashes[2]
    blocks = baked()
    assert sum(counts[2:]) == 66
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
    assert counts[-1] == 22
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


@pytest.mark.parametrize("varying", [("alpha",), ("alpha", "sigma_t", "r0")])
def test_many_rows_are_layered_as_by_light_transport(model, varying):
    rng, count = np.random.default_rng(2), 3 * TRANSPORTED[1]
    given = {"alpha": (0.05, 0.5), "sigma_t": (0.0, 4.0), "r0": (0.05, 0.95)}
    numbers = {
        name: rng.uniform(*ends, count) if name in varying else np.full(count, ends[1])
        for name, ends in given.items()
    }
    r0 = numbers.pop("r0")
    rows = np.zeros((count, model.arch.latent + 5), np.float32)
    rows[:, [0, 2, 4]] = 0.2, 1, 1.5
    rows[:, 1] = r0
    rows[:, model.arch.lobe : model.arch.latent] = model.networks.empty_rest()
    coat = {"eta": 1.5, "albedo": 0.7, "g": 0.0} | numbers
    rows[:, model.arch.latent :] = np.stack(
        [np.broadcast_to(coat[name], count) for name in CoatParameters._fields], axis=1
    )
    some = slice(None, 60)
    own = CoatParameters.of_columns([*rows[some, model.arch.latent :].T])
    found = layer_rows(model, rows)[some]
    expected = transported(model, rows[some, : model.arch.latent], own)
    wi, wo = model.networks.pairs()
    f, true = (model.networks.f(z[:, None], wi, wo) for z in (found, expected))
    measure = model.networks.basis.measure
    errors = np.abs(f - true) @ measure / (true @ measure)
    # Interpolated between 384 rows in one and in three parameters
    assert errors.mean() < 0.001
    assert errors.max() < 0.01


def test_rows_without_a_coat_keep_their_bottom(model):
    rng, count = np.random.default_rng(3), 2 * TRANSPORTED[1]
    rows = np.zeros((count, model.arch.latent + 5), np.float32)
    rows[:, [0, 2, 4]] = 0.2, 1, 1.5
    rows[:, 1] = rng.uniform(0.1, 0.9, count)
    rows[:, model.arch.lobe : model.arch.latent] = model.networks.empty_rest()
    sigma_t = rng.uniform(0, 1, count) * (np.arange(count) % 2)
    coat = CoatParameters(0.1, 1.0, 0.5, sigma_t, 0.0)
    rows[:, model.arch.latent :] = np.stack(np.broadcast_arrays(*coat.columns()), axis=1)
    found = layer_rows(model, rows)
    np.testing.assert_array_equal(found[::2], rows[::2, : model.arch.latent])
    assert (found[1::2] != rows[1::2, : model.arch.latent]).any(axis=1).all()
