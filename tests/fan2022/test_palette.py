"""The paper's training data: components of stacks, their direction pairs, and their files."""

import dataclasses

import numpy as np
import pytest
from fan2022.palette import Palette, PaperData, make_shard, read_shard

from urushi.train.tables import generate
from urushi.walk import analytic

ALL = slice(0, 5000)

#: Two stacks with few pairs of each part, but for the walks.
DATA = PaperData(4, 5, 3, pairs=16)


def table(coats: int, rows: slice = ALL, bottom: str = "conductor"):
    return Palette(coats, bottom, components=50, stacks=5000).draw(rows)


def test_parameters_follow_table_2():
    stacks = table(1)
    assert stacks.alpha.min() >= np.float32(0.216**3)
    assert stacks.eta.min() >= 1.05 and stacks.eta.max() <= 2
    assert set(np.unique(stacks.sigma_t)) == {0, 1, 2, 5}
    # albedo = 1 - u^2: mean 2/3, standard deviation 0.3, of 5,000 draws
    assert stacks.albedo.mean() == pytest.approx(2 / 3, abs=5 * 0.3 / np.sqrt(5000))
    assert not stacks.g.any()


def test_stacks_are_made_of_the_components():
    dielectrics, conductors = table(0, slice(0, 50), "dielectric"), table(0, slice(0, 50))
    stacks, source = table(1), Palette(1, components=50, stacks=5000)
    top, bottom, albedo, sigma_t = source.parts(ALL)
    np.testing.assert_array_equal(stacks.alpha[:, 0], dielectrics.bottom["alpha"][top])
    np.testing.assert_array_equal(stacks.eta[:, 0], dielectrics.bottom["eta"][top])
    np.testing.assert_array_equal(stacks.bottom["r0"], conductors.bottom["r0"][bottom])
    np.testing.assert_array_equal(stacks.albedo[:, 0], albedo.astype(np.float32))
    np.testing.assert_array_equal(stacks.sigma_t[:, 0], sigma_t)
    three = table(2, slice(0, 300))
    top, below, _, _ = Palette(2, components=50, stacks=5000).parts(slice(0, 300))
    for name in ("alpha", "eta", "albedo", "sigma_t"):
        np.testing.assert_array_equal(getattr(three, name)[:, 1], getattr(stacks, name)[below, 0])
    np.testing.assert_array_equal(three.bottom["alpha"], stacks.bottom["alpha"][below])
    np.testing.assert_array_equal(three.alpha[:, 0], dielectrics.bottom["alpha"][top])
    some = table(2, slice(100, 130))  # rows do not depend on which others are drawn
    np.testing.assert_array_equal(some.albedo, three.albedo[100:130])


def test_shards_hold_all_parts_in_order_and_depend_on_nothing_else(monkeypatch):
    assert DATA.shards() == 4
    monkeypatch.setattr("fan2022.palette.SHARD_PAIRS", 32)
    assert DATA.shards() == 2 + 2 + 3 + 2
    (name, rows) = DATA.places()[6]
    assert (name, rows) == ("two-layer", slice(4, 5))
    last, again = make_shard(DATA, 6), make_shard(DATA, 6)
    assert last["wi"].shape == (1, 16, 3) and last["f"].shape == (1, 16)
    assert (last["f"] > 0).any()
    for name, values in last.items():
        np.testing.assert_array_equal(values, again[name])


def test_components_are_exact_and_have_one_pair_in_each_stratum():
    k = 4
    data = dataclasses.replace(DATA, pairs=k**4)
    arrays = make_shard(data, 1)
    wi, wo, f = arrays["wi"], arrays["wo"], arrays["f"]
    bottom = data.parts["dielectric"][0].draw(slice(0, 4)).bottom
    row = np.arange(4, dtype=np.uint32).repeat(k**4)
    exact = analytic.rows("dielectric", bottom, row, wi.reshape(-1, 3), wo.reshape(-1, 3))
    np.testing.assert_array_equal(f.ravel(), exact)
    cells = []
    for w in (wi.astype(np.float64), wo.astype(np.float64)):
        np.testing.assert_allclose(np.linalg.norm(w, axis=-1), 1, atol=1e-6)
        theta, phi = np.arccos(w[..., 2]), np.arctan2(w[..., 1], w[..., 0]) % (2 * np.pi)
        # float32 may cross a border that lies within its rounding
        cells += [theta / (np.pi / 2) * k, phi / (2 * np.pi) * k]
    index = np.floor(np.stack(cells)).astype(int)
    for stack in range(4):
        assert len({tuple(cell) for cell in index[:, stack].T}) >= 0.98 * k**4
    assert not np.array_equal(wi[0], wi[1])


def test_a_store_holds_the_shards(tmp_path):
    store = generate(DATA, tmp_path / "data", make_shard)
    for name, values in zip(("wi", "wo", "f"), read_shard(store, 2), strict=True):
        np.testing.assert_array_equal(values, make_shard(DATA, 2)[name])
