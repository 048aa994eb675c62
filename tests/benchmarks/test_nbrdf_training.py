"""A neural BRDF learns a BRDF from its values."""

import numpy as np
import pytest
from benchmarks.rivals import nbrdf
from benchmarks.rivals.ggx_fit import GgxFit, Lobe


@pytest.fixture
def plastic():
    return GgxFit(np.array([0.4, 0.2, 0.1]), (Lobe(0.3, 0.1, np.ones(3)),))


def pairs(count, seed):
    rng = np.random.default_rng(seed)
    z, phi = np.sqrt(rng.uniform(0.02, 1, (2, count))), rng.uniform(0, 2 * np.pi, (2, count))
    r = np.sqrt(1 - z * z)
    return np.stack([r * np.cos(phi), r * np.sin(phi), z], axis=-1).astype(np.float32)


def test_it_learns_an_analytic_brdf(plastic):
    learned = nbrdf.train(plastic.f, passes=10, samples=100_000)
    wi, wo = pairs(2000, 1)
    wanted, found = plastic.f(wi, wo), learned.f(wi, wo)
    error, spread = (np.abs(x - wanted).mean() for x in (found, wanted.mean(axis=0)))
    assert error < 0.1 * spread  # of what the best constant leaves


def test_the_same_seed_gives_the_same_network(plastic):
    one, two, other = (
        nbrdf.train(plastic.f, passes=1, samples=5_000, seed=seed) for seed in (1, 1, 2)
    )
    np.testing.assert_array_equal(one.weights, two.weights)
    assert (one.weights != other.weights).any()
