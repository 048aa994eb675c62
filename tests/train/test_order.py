"""The order of examples: each once an epoch, shuffled as a whole, for any division."""

import numpy as np

from urushi.train.layering import shuffled

SIZE = 2413


def test_every_item_comes_once_an_epoch():
    order = shuffled(SIZE, seed=0)
    first, second = (order(epoch * SIZE, SIZE) for epoch in (0, 1))
    for items in (first, second):
        assert sorted(items) == list(range(SIZE))
    assert (first != second).any()


def test_items_are_shuffled_as_a_whole():
    items = shuffled(SIZE, seed=0)(0, SIZE)
    # The mean of the first half of the sequence is that of a sample of 1,206 of 2,413.
    assert abs(items[:1206].mean() - items.mean()) < 4 * items.std() / np.sqrt(2 * 1206)


def test_the_order_is_a_function_of_seed_and_place():
    def take(start, count, seed=0):
        return shuffled(SIZE, seed)(start, count)

    whole = take(0, 6000)
    for start, count in ((0, 5), (1200, 3000), (2412, 2), (5000, 1000)):
        np.testing.assert_array_equal(take(start, count), whole[start : start + count])
    backwards = shuffled(SIZE, 0)
    for start in (5000, 2500, 100):
        np.testing.assert_array_equal(backwards(start, 50), whole[start : start + 50])
    assert (take(0, 100, seed=1) != whole[:100]).any()
