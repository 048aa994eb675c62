"""Values and measures from which the basis of two widths is fitted."""

import numpy as np
import pytest

from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY
from urushi.core.probe_pairs import probe_pairs
from urushi.core.stretched import components_of, features_of, stretched
from urushi.nets import lobe as lobes
from urushi.nets.weights import default_model
from urushi.train import stretched_fit

BRUSHED = np.float32([0.15, 0.9, 1, 0, 1.5, 0, 0.4])


def albedo() -> float:
    """Mean of f over pairs of cosine density."""
    wi, wo = cosine_pairs(np.random.default_rng(0), 1 << 18)
    return float(lobes.f(BRUSHED, wi, wo).mean())


@pytest.mark.parametrize("log_stretch", [0.0, 0.5])
def test_pairs_have_the_coordinates_of_their_nodes(log_stretch):
    wi, wo, _ = stretched_fit.pairs_at(log_stretch, np.random.default_rng(1))
    both, apart = components_of(features_of(wi, wo).astype(float))
    places, _ = stretched(both, apart, np.exp(2 * log_stretch), NUMPY)
    axes = [np.linspace(0, 1, count) for count in stretched_fit.NODES]
    nodes = np.meshgrid(*axes, indexing="ij")
    # Where the difference angle or the half angle is zero, others mean nothing.
    inside = [x.ravel()[:, None] for x in nodes]
    high = np.minimum(wi[..., 2], wo[..., 2]) > 0.05
    seen = high & (inside[0] > 0.2) & (inside[1] > 0.1)
    for place, node in zip(places, inside, strict=True):
        error = np.abs(place - node)[seen]
        assert np.median(error) < 1e-4 and np.percentile(error, 95) < 0.02


def test_measures_integrate():
    """A brushed lobe, by nodes and by probe pairs: coarse rules, good to some per cent."""
    expected = albedo()
    wi, wo, measure = stretched_fit.pairs_at(0.5, np.random.default_rng(2))
    found = (lobes.f(BRUSHED, wi, wo) * measure).sum()
    assert found == pytest.approx(expected, rel=0.05)
    values = lobes.f(BRUSHED, *probe_pairs(384, 2))
    assert values @ stretched_fit.probe_measure(384) == pytest.approx(expected, rel=0.2)


@pytest.mark.slow
def test_given_functions_stay_and_codes_improve():
    parts = [stretched_fit.transported(seed) for seed in range(10)]
    values = stretched_fit.Values(*map(np.concatenate, zip(*parts, strict=True)))
    rows = default_model().params["basis.rows"]
    fit, prior = stretched_fit.fitted(rows, values)
    np.testing.assert_array_equal(fit[:, : rows.shape[1]], rows)
    free = 1e-3 * np.eye(len(prior))  # ten stacks have no covariance
    without = np.concatenate([rows, np.zeros((len(rows), len(prior) + 1 - rows.shape[1]))], axis=1)
    errors = [stretched_fit.solved(x, free, values)[1].mean() for x in (fit, without)]
    assert errors[0] < 0.5 * errors[1]
