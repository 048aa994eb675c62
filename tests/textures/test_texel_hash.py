"""Row hashes: only equal rows have equal hashes."""

import numpy as np
import pytest

from urushi.textures import texel_hash


@pytest.mark.parametrize(("count", "kinds"), [(0, 1), (1, 1), (7, 3), (5000, 50), (5000, 2**40)])
def test_unique_rows_represent_all_keys(count, kinds):
    keys = np.random.default_rng(0).integers(kinds, size=count).astype(np.uint64)
    first, label = texel_hash.unique_rows(keys)
    np.testing.assert_array_equal(keys[first][label], keys)  # every key has an equal representative
    assert len(first) == len(set(keys.tolist()))  # no representative occurs twice
    assert (np.diff(first) > 0).all()
    np.testing.assert_array_equal(label[first], np.arange(len(first)))


def test_only_equal_rows_have_equal_hashes():
    rng = np.random.default_rng(1)
    columns = [rng.integers(4, size=3000).astype(np.float32) for _ in range(4)]
    found = texel_hash.row_hashes(columns)
    rows = {tuple(row) for row in np.stack(columns, axis=1).tolist()}
    assert len(np.unique(found)) == len(rows)
    again = texel_hash.row_hashes(
        [column * np.float32(1 + 1e-6) for column in columns]
    )  # with the rounding errors of a filter
    np.testing.assert_array_equal(again, found)
    assert (texel_hash.row_hashes(columns[::-1]) != found).any()
