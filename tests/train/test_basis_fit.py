"""The fit of the basis finds functions that span the tables, and integrals are sums over probes."""

import numpy as np
import pytest
from tests.train.conftest import log_f

from urushi.core.table import node_pairs
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.code_fit import solve_codes
from urushi.train import basis_fit
from urushi.train.basis_fit import Tables

#: Factors of three functions of one width.
FACTORS = np.zeros(3, int)


@pytest.fixture(scope="module")
def measure():
    return basis_fit.node_measure()


def tables_of(logs: np.ndarray, top: np.ndarray, measure: np.ndarray) -> Tables:
    """Materials of one width, of values (N, P)."""
    integrals = (top @ measure).astype(np.float32)[:, None, None]
    shares = np.broadcast_to(measure, (len(logs), 1, len(measure)))
    return Tables(logs[:, None].astype(np.float32), integrals, shares, np.empty((1, 0)))


@pytest.fixture(scope="module")
def materials(measure):
    """Materials of a family with three functions under an interface."""
    rng = np.random.default_rng(0)
    logs = log_f(*node_pairs(), rng.standard_normal((60, 3)))
    top = lobes.f(lobes.of_coat(np.full(60, 0.3), np.full(60, 1.5))[:, None], *node_pairs())
    return basis_fit.prepared(tables_of(logs, top, measure))[0]


@pytest.fixture(scope="module")
def rests(materials):
    """f of the rests at 96 probe pairs."""
    return basis_fit.probed({"table": materials.logs[:, 0]}, 96)


@pytest.fixture(scope="module")
def basis(materials, rests):
    given = np.tile(np.array([0, 1], np.float32), (materials.logs.shape[2], 1))
    rows, prior = basis_fit.fit_basis(materials, given, FACTORS)
    measure = basis_fit.probe_measure(rests, materials.rest().ravel())
    return Basis(rows, np.zeros(4, int), measure, prior.astype(float))


def test_the_measure_integrates_over_pairs_of_cosine_density(measure):
    """The mean cosine is 2/3, and the mean product of both 4/9."""
    assert measure.sum() == pytest.approx(1, abs=1e-4)
    cosines = [w[:, 2] for w in node_pairs()]
    assert measure @ np.mean(cosines, axis=0) == pytest.approx(2 / 3, abs=0.005)
    assert measure @ np.prod(cosines, axis=0) == pytest.approx(4 / 9, abs=0.005)


def test_tables_in_the_span_are_exact(basis, materials, rests):
    codes = solve_codes(basis, rests, np.ones_like(rests))
    assert materials.errors(basis.rows[:, 1:], FACTORS, codes).max() < 2e-3


def test_a_lambertian_is_exact(basis):
    """The constant is a function and the mean is zero, so that its code is its gain."""
    assert not basis.rows[:, 0].any()
    assert (basis.rows[:, 1] == 1).all()
    white = np.full((1, 96), 0.8 / np.pi, np.float32)
    codes = solve_codes(basis, white, np.ones_like(white))
    np.testing.assert_allclose(codes, [[np.log(0.8 / np.pi), 0, 0]], atol=1e-4)


def test_functions_are_standardised(basis, rests, measure):
    """Codes have the mean square 1 and mean products 0, and the first has the largest effect."""
    codes = solve_codes(basis, rests, np.ones_like(rests))[:, 1:]
    np.testing.assert_allclose(codes.T @ codes / len(codes), np.eye(2), atol=0.05)
    effects = measure @ basis.rows[:, 2:] ** 2
    assert effects[0] > effects[1]


def test_sums_over_probes_are_integrals(basis, materials, rests):
    probed = rests @ basis.measure  # whose weights are tied to equal ones
    assert np.abs(probed / materials.rest().ravel() - 1).mean() < 0.05
    assert (basis.measure > 0).all()


def test_materials_without_a_rest_teach_nothing(measure):
    logs = np.full((2, len(measure)), -3.0)
    logs[1] = -20
    top = np.ones_like(logs, np.float32)
    tables, rows = basis_fit.prepared(tables_of(logs, top, measure))
    assert rows.tolist() == [0]
    assert len(tables.logs) == 1
