"""The order of examples: each once an epoch, in similar windows that fit into memory."""

import numpy as np
import pytest

from urushi.train.order import Order

SIZES = [[40] * 30 + [13], [20] * 60]  # items of the shards of two parts: 1,213 and 1,200
FIRST = 31  # shards of the first part


def sequence(order, start, count):
    """(shard, place in it) of consecutive items."""
    flat = np.concatenate(SIZES)
    found = []
    for run in order.runs(start, count):
        owner = np.concatenate([np.full(flat[k], k) for k in run.window])
        place = np.concatenate([np.arange(flat[k]) for k in run.window])
        found.append(np.stack([owner[run.items], place[run.items]], axis=-1))
    return np.concatenate(found)


@pytest.mark.parametrize("capacity", [1, 100, 400, 10_000])
def test_every_item_comes_once_an_epoch(capacity):
    order = Order(SIZES, capacity, seed=0)
    assert order.size == 2413
    for epoch in range(2):
        items = sequence(order, epoch * order.size, order.size)
        assert len(np.unique(items, axis=0)) == order.size


@pytest.mark.parametrize("capacity", [40, 400])
def test_windows_fit_and_hold_both_parts_equally(capacity):
    order = Order(SIZES, capacity, seed=0)
    flat = np.concatenate(SIZES)
    windows = order.windows(3)
    assert max(flat[list(window)].sum() for window in windows) <= capacity
    if capacity == 400:
        # Half of the items are in each part; a window's ends cut off at most two shards of each.
        for window in windows[:-1]:
            share = flat[[k for k in window if k < FIRST]].sum() / flat[list(window)].sum()
            assert abs(share - 0.5) < 0.25


def test_data_that_fit_are_one_window_that_is_shuffled_as_a_whole():
    order = Order(SIZES, 2413, seed=0)
    assert order.windows(0) == order.windows(1) == [tuple(range(91))]
    shards = sequence(order, 0, 2413)[:, 0]
    # The mean rank of the first half of the sequence is that of a sample of 1,206 of 2,413.
    assert abs(shards[:1206].mean() - shards.mean()) < 4 * shards.std() / np.sqrt(2 * 1206)


def test_the_order_is_a_function_of_seed_key_and_place():
    def take(start, count, seed=0, key=0):
        return sequence(Order(SIZES, 300, seed, key), start, count)

    whole = take(0, 6000)
    for start, count in ((0, 5), (1200, 3000), (2412, 2), (5000, 1000)):
        np.testing.assert_array_equal(take(start, count), whole[start : start + count])
    backwards = Order(SIZES, 300, 0)
    for start in (5000, 2500, 100):
        np.testing.assert_array_equal(sequence(backwards, start, 50), whole[start : start + 50])
    assert (take(0, 100, seed=1) != whole[:100]).any()
    assert (take(0, 100, key=1) != whole[:100]).any()


def test_each_run_names_the_window_that_follows():
    order = Order(SIZES, 300, seed=0)
    runs = order.runs(0, 3 * order.size)
    assert [run.following for run in runs[:-1]] == [run.window for run in runs[1:]]
