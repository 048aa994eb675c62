"""Rows are told apart by their keys."""

import numpy as np
import pytest

from urushi.textures import texel_hash


@pytest.mark.parametrize(("count", "kinds"), [(0, 1), (1, 1), (7, 3), (5000, 50), (5000, 2**40)])
def test_distinct_keys_stand_for_all(count, kinds):
    some = np.random.default_rng(0).integers(kinds, size=count).astype(np.uint64)
    first, label = texel_hash.unique_rows(some)
    np.testing.assert_array_equal(some[first][label], some)  # everyone is stood for by an equal
    assert len(first) == len(set(some.tolist()))  # and none twice
    assert (np.diff(first) > 0).all()
    np.testing.assert_array_equal(label[first], np.arange(len(first)))


def test_equal_rows_alone_have_equal_keys():
    rng = np.random.default_rng(1)
    columns = [rng.integers(4, size=3000).astype(np.float32) for _ in range(4)]
    found = texel_hash.row_hashes(columns)
    rows = {tuple(row) for row in np.stack(columns, axis=1).tolist()}
    assert len(np.unique(found)) == len(rows)
    again = texel_hash.row_hashes(
        [column * np.float32(1 + 1e-6) for column in columns]
    )  # as a filter gives them
    np.testing.assert_array_equal(again, found)
    assert (texel_hash.row_hashes(columns[::-1]) != found).any()
