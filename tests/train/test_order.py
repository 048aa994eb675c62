"""The order of examples: each once an epoch, shuffled as a whole, for any division."""

import numpy as np
from numpy.testing import assert_array_equal

from urushi.train.layering import shuffled

SIZE = 2413


def test_every_item_comes_once_an_epoch_shuffled_as_a_whole():
    first, second = (shuffled(SIZE, 0, epoch * SIZE, SIZE) for epoch in (0, 1))
    for items in (first, second):
        assert sorted(items) == list(range(SIZE))
        # The mean of the first half of the sequence is that of a sample of 1,206 of 2,413.
        assert abs(items[:1206].mean() - items.mean()) < 4 * items.std() / np.sqrt(2 * 1206)
    assert (first != second).any()


def test_the_order_is_a_function_of_seed_and_place():
    whole = shuffled(SIZE, 0, 0, 6000)
    for start, count in ((0, 5), (1200, 3000), (2412, 2), (5000, 1000)):
        assert_array_equal(shuffled(SIZE, 0, start, count), whole[start : start + count])
    assert (shuffled(SIZE, 1, 0, 100) != whole[:100]).any()
