"""Values from which the basis of two widths is fitted, and coats over its codes."""

import numpy as np
import pytest

from urushi.checks import MIN_ALPHA
from urushi.core.direction_sets import cosine_pairs
from urushi.core.namespace import NUMPY, Components
from urushi.core.probe_pairs import pair_measure, probe_pairs
from urushi.core.stretched import stretched
from urushi.nets import lobe as lobes
from urushi.nets.networks import Architecture
from urushi.nets.weights import default_model
from urushi.train import basis_fit, distribution, stretched_tables
from urushi.train.stretched_tables import nodes_of

BRUSHED = np.float32([0.15, 0.9, 1, 0, 1.5, 0, 0.4])


@pytest.mark.parametrize("log_stretch", [0.0, 0.5])
def test_pairs_have_the_coordinates_of_their_nodes(log_stretch):
    wi, wo = nodes_of(log_stretch, [1]).pairs
    both, apart = (Components(*np.moveaxis(w.astype(float), -1, 0)) for w in (wi + wo, wi - wo))
    places, _ = stretched(both, apart, np.exp(2 * log_stretch), NUMPY)
    axes = [np.linspace(0, 1, count) for count in stretched_tables.NODES]
    nodes = [x.ravel() for x in np.meshgrid(*axes, indexing="ij")]
    # Where the difference angle or the half angle is zero, others mean nothing.
    high = np.minimum(wi[..., 2], wo[..., 2]) > 0.05
    seen = high & (nodes[0] > 0.2) & (nodes[1] > 0.1)
    for place, node in zip(places, nodes, strict=True):
        error = np.abs(place - node)[seen]
        assert np.median(error) < 1e-4 and np.percentile(error, 95) < 0.02


def test_measures_integrate():
    """A brushed lobe, by nodes and by probe pairs: coarse rules, good to some per cent."""
    expected = lobes.f(BRUSHED, *cosine_pairs(np.random.default_rng(0), 1 << 18)).mean()
    nodes = nodes_of(0.5, [2])
    by_nodes = (lobes.f(BRUSHED, *nodes.pairs) * nodes.measure).sum()
    by_probes = lobes.f(BRUSHED, *probe_pairs(384, 2)) @ pair_measure(384)
    assert by_nodes == pytest.approx(expected, rel=0.05)
    assert by_probes == pytest.approx(expected, rel=0.2)


def test_coats_of_two_widths():
    """Pairs share an interface; some have none, and the least widths, as the network sees them."""
    coats = distribution.draw_coats_of_two(np.random.default_rng(0), 400)
    assert (coats[::2, [0, 1, 5]] == coats[1::2, [0, 1, 5]]).all()
    bare = coats[:, 1] == 1
    assert 0.01 < bare.mean() < 0.1
    assert (coats[bare][:, [0, 5]] == np.float32(MIN_ALPHA)).all()
    ratio = coats[:, 0] / coats[:, 5]
    assert (ratio == 1).mean() > 0.2
    assert np.abs(np.log(ratio)).max() < np.log(distribution.MOST_QUOTIENT) + 1e-5


@pytest.mark.slow
def test_given_functions_stay_and_codes_improve():
    rows = [row for number in range(6) for row in stretched_tables.levels(384, 0, number)]
    held = {name: np.stack([row[name] for row in rows]) for name in rows[0]}
    tables, _ = basis_fit.prepared(basis_fit.materials(held))
    given = default_model().params["basis.rows"]
    factors = Architecture(52, 384, widths=2, azimuthal=(8, 8, 4, 4, 4)).factors[1:]
    fit, _ = basis_fit.fit_basis(tables, given, factors)
    np.testing.assert_array_equal(fit[:, : given.shape[1]], given)
    without = np.concatenate([given, 0 * fit[:, given.shape[1] :]], axis=1)
    errors = []
    for functions in (fit, without):
        own = tables.at_nodes(functions)[:, 1:]
        codes = tables.codes(own, factors, tables.light_weights())
        errors.append(tables.errors(own, factors, codes).mean())
    assert errors[0] < 0.5 * errors[1]
