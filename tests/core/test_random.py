"""Random generators of lanes: reproducible, uniform and independent of each other."""

import drjit as dr
import numpy as np
import pytest
from scipy import stats

from urushi.core.random import hashed_stream, stream

LANES = 20000


@pytest.fixture(params=["stream", "hashed_stream"])
def generator(request, jit):
    """A function of the variant number (0, 1, ...) that makes generators of `LANES` lanes."""
    lane = dr.arange(jit.UInt32, LANES)
    if request.param == "stream":
        return lambda number: stream(jit.PCG32, lane, number)
    # Neighbouring floats, as the directions of neighbouring pixels are.
    value = jit.Float(1) + jit.Float(lane) * 1.2e-7
    return lambda number: hashed_stream(jit.PCG32, [jit.Float(float(number)), value])


def test_the_same_seed_gives_the_same_numbers(generator):
    a, b, other = (generator(k).next_float32().numpy() for k in (0, 0, 1))
    np.testing.assert_array_equal(a, b)
    assert (a != other).mean() > 0.99


def test_lanes_are_uniform_and_not_correlated(generator):
    rng = generator(3)
    first, second = (rng.next_float32().numpy() for _ in range(2))
    other = generator(4).next_float32().numpy()
    assert stats.kstest(first, "uniform").pvalue > 1e-3
    for x, y in ((first[1:], first[:-1]), (first, second), (first, other)):
        # The correlation of independent numbers has a standard deviation of 1 / sqrt(LANES).
        assert abs(np.corrcoef(x, y)[0, 1]) < 4 / np.sqrt(LANES)
