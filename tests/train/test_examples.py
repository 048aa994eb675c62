"""Batches: each example once an epoch, with its own arrays, for any division into steps."""

import dataclasses

import numpy as np
import pytest

from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.errors import ParameterError
from urushi.nets import lobe
from urushi.nets.architecture import Architecture
from urushi.nets.features import direction_features
from urushi.train import examples
from urushi.train.batches import batches
from urushi.train.distribution import BOTTOMS, Extended, Table2
from urushi.train.examples import bottom_lobes, bottom_rest
from urushi.train.store import DataSpec, Part, Store, generate
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS


@pytest.fixture(scope="module")
def depths(tiny, tiny_data):
    return examples.load(Store(tiny_data, tiny.data), tiny.arch, tiny.pairs)


@pytest.fixture(scope="module")
def held(depths):
    return [depth.examples() for depth in depths]


def test_examples_are_grouped_by_the_number_of_coats(held):
    assert [len(depth.probes) for depth in held] == [12, 32, 8]
    assert [depth.coats.shape[1] for depth in held] == [0, 1, 2]
    for depth in held:
        np.testing.assert_array_equal(depth.stack, np.repeat(np.arange(len(depth.probes)), 2))


def test_the_arrays_of_an_example_belong_together(tiny, tiny_data, held):
    store = Store(tiny_data, tiny.data)
    arrays = store.read(tiny.data.parts[3])
    row, item = 5, 11  # the second run of the sixth stack
    pairs = slice(8, 16)
    np.testing.assert_array_equal(held[2].f[item], arrays["f"][row, pairs])
    np.testing.assert_array_equal(
        held[2].features[item],
        direction_features(arrays["wi"][row, pairs], arrays["wo"][row, pairs]),
    )
    np.testing.assert_array_equal(held[2].coats[row], arrays["coats"][row])
    alpha, eta = arrays["coats"][row, 0, :2]
    np.testing.assert_array_equal(
        held[2].top[item],
        lobe.f(lobe.of_coat(alpha, eta), arrays["wi"][row, pairs], arrays["wo"][row, pairs]),
    )
    alpha, r0 = arrays["bottom"][row]  # a conductor, which is a lobe and nothing else
    np.testing.assert_array_equal(held[2].lobes[row, :4], [alpha, r0, 1, 0])
    assert not held[2].probes[row].any()


@pytest.mark.parametrize("kind", BOTTOMS)
def test_a_bottom_is_its_lobe_and_the_rest(kind):
    """A fitted lobe is above the bottom at some pairs, mostly by little."""
    columns = Extended(1, kind).sample(np.random.default_rng(7), 24).bottom
    bottom = np.stack(list(columns.values()), axis=-1)
    own = bottom_lobes(kind, bottom, Architecture())
    rest = bottom_rest(kind, bottom, own, Architecture())
    wi, wo = probe_pairs(PROBES)
    for row in range(len(bottom)):
        f = analytic.rows(kind, columns, np.full(PROBES, row, np.uint32), wi, wo)
        sum_of_both = lobe.f(own[row], wi, wo) + rest[row]
        assert (sum_of_both >= f * (1 - 1e-2) - 1e-5).all()  # rounding of sharp lobes
        assert np.median(sum_of_both / (f + 1e-3)) < 1.05
    if KINDS[kind].family.bare:
        assert not rest.any()
    if kind == "diffuse":
        assert not own[:, 1:4].any()


def test_batches_do_not_depend_on_the_division_into_steps(tiny, depths):
    whole = batches(depths, tiny.stages[0].stacks, seed=1)(0, 40)
    other = batches(depths, tiny.stages[0].stacks, seed=1)
    pieces = [other(start, count) for start, count in ((0, 3), (3, 30), (33, 7))]
    for name in ("probes", "features", "f"):
        joined = np.concatenate([getattr(piece, name) for piece in pieces])
        np.testing.assert_array_equal(getattr(whole, name), joined)
    np.testing.assert_array_equal(
        batches(depths, tiny.stages[0].stacks, seed=1)(33, 7).f, pieces[2].f
    )
    assert (batches(depths, tiny.stages[0].stacks, seed=2)(0, 40).f != whole.f).any()


def test_an_epoch_has_every_example_once(tiny, depths, held):
    # 16 items have two coats, four of them in a step: an epoch is four steps. They come first.
    taken = batches(depths, tiny.stages[0].stacks, seed=1)(0, 8)
    for epoch in (slice(0, 4), slice(4, 8)):
        values = taken.f[epoch, :4].reshape(16, -1)
        np.testing.assert_array_equal(np.sort(values, axis=0), np.sort(held[2].f, axis=0))
    assert (taken.f[:4, :4] != taken.f[4:, :4]).any()


def test_deeper_stacks_come_first_so_that_coats_match_their_stacks(tiny, depths, held):
    batch = batches(depths, tiny.stages[0].stacks, seed=1)(0, 2)
    lowest, highest = batch.coats
    assert lowest.shape == (2, 13, 5)
    assert highest.shape == (2, 4, 5)
    for step in range(2):
        for row in range(4):
            match = (held[2].lobes == batch.lobes[step, row]).all(-1)
            coats = held[2].coats[match][0]
            np.testing.assert_array_equal(coats[1], lowest[step, row])
            np.testing.assert_array_equal(coats[0], highest[step, row])


def test_probed_stacks_are_encoded_from_their_own_values(tiny, tmp_path):
    arch = dataclasses.replace(tiny.arch, probes=PROBES)
    part = Part("probed", Table2(1), 8, PROBES + 16, 4, "probed")
    store = generate(DataSpec((part,), seed=6), tmp_path / "data")
    (depth,) = examples.load(store, arch, 8)  # no coat is layered
    arrays, held = store.read(part), depth.examples()
    top = lobe.f(held.lobes[:, None], *probe_pairs(PROBES))
    np.testing.assert_array_equal(held.lobes[:, 0], arrays["coats"][:, 0, 0])
    np.testing.assert_array_equal(held.probes, np.maximum(arrays["f"][:, :PROBES] - top, 0))
    np.testing.assert_array_equal(held.f, arrays["f"][:, PROBES:].reshape(16, 8))
    assert held.coats.shape == (8, 0, 5)
    with pytest.raises(ParameterError, match="holds 192 probes, but the architecture's encoder"):
        examples.load(store, tiny.arch, 8)


def test_presets_that_do_not_fit_their_data_get_one_sentence(tiny, tiny_data, depths):
    with pytest.raises(ParameterError, match="stacks of up to 2 coats, but the preset draws"):
        batches(depths, (4, 4), seed=0)
    with pytest.raises(ParameterError, match="multiple of the 12 that a step uses"):
        examples.load(Store(tiny_data, tiny.data), tiny.arch, 12)
    store = Store(tiny_data, tiny.data)
    gap = dataclasses.replace(store.spec, parts=store.spec.parts[1:])
    with pytest.raises(ParameterError, match="without a gap, not of 1, 2"):
        examples.load(Store(store.path, gap), tiny.arch, tiny.pairs)
    whole = Part("whole", Table2(1), 8, 81, 4, "stratified")
    foreign = dataclasses.replace(store.spec, parts=(*store.spec.parts, whole))
    with pytest.raises(ParameterError, match="'whole' has directions 'stratified', which"):
        examples.load(Store(store.path, foreign), tiny.arch, tiny.pairs)
