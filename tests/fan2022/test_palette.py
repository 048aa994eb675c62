"""The paper's set of materials: components of stacks, and their direction pairs."""

import numpy as np
import pytest

from urushi.errors import FileError, ParameterError
from urushi.fan2022.preset import Palette
from urushi.fan2022.store import DataSpec, Part, Store

ALL = slice(0, 5000)


def table(coats: int, rows: slice = ALL, bottom: str = "conductor"):
    source = Palette(coats, bottom, components=50, stacks=5000)
    return source.draw(np.random.default_rng(0), rows)


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


def test_three_layers_are_two_with_one_more_on_top():
    two, three = table(1), table(2, slice(0, 300))
    top, below, _, _ = Palette(2, components=50, stacks=5000).parts(slice(0, 300))
    for name in ("alpha", "eta", "albedo", "sigma_t"):
        np.testing.assert_array_equal(getattr(three, name)[:, 1], getattr(two, name)[below, 0])
    np.testing.assert_array_equal(three.bottom["alpha"], two.bottom["alpha"][below])
    dielectrics = table(0, slice(0, 50), "dielectric")
    np.testing.assert_array_equal(three.alpha[:, 0], dielectrics.bottom["alpha"][top])


def test_rows_do_not_depend_on_which_others_are_drawn():
    some = table(2, slice(100, 130))
    np.testing.assert_array_equal(some.albedo, table(2).albedo[100:130])


def test_a_store_is_resumed_by_the_same_palette_alone(tmp_path):
    def spec(**options):
        return DataSpec((Part("a", Palette(0, components=7, **options), 7, 81, 1),))

    store = Store.create(tmp_path / "data", spec(seed=3))
    assert Store.create(tmp_path / "data", spec(seed=3)) == store
    with pytest.raises(FileError, match="its part 'a' has another specification"):
        Store.create(tmp_path / "data", spec(seed=4))


def test_impossible_ones_are_refused():
    with pytest.raises(ParameterError, match="has 100 stratified pairs; give a fourth power"):
        Part("a", Palette(1), 10, 100, 1)


def test_every_stratum_has_one_pair_and_every_stack_its_own():
    k = 4
    part = Part("a", Palette(1), 2, k**4, 1)
    wi, wo = part.draw_pairs(np.random.default_rng(8), 2)
    assert wi.dtype == np.float32
    cells = []
    for w in (wi.astype(np.float64), wo.astype(np.float64)):
        np.testing.assert_allclose(np.linalg.norm(w, axis=1), 1, atol=1e-6)
        theta, phi = np.arccos(w[:, 2]), np.arctan2(w[:, 1], w[:, 0]) % (2 * np.pi)
        # float32 may cross a border that lies within its rounding
        cells += [theta / (np.pi / 2) * k, phi / (2 * np.pi) * k]
    index = np.floor(np.stack(cells)).astype(int).reshape(4, 2, -1)
    for stack in (0, 1):
        assert len({tuple(cell) for cell in index[:, stack].T}) >= 0.98 * k**4
    assert not np.array_equal(wi[: k**4], wi[k**4 :])
