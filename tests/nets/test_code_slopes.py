"""Derivatives of codes by the values that they are solved for."""

import numpy as np
import pytest

from urushi.nets import lobe
from urushi.nets.basis import Basis, decode
from urushi.nets.code_fit import slopes, solve_codes
from urushi.nets.weights import default_model

COUNT = 12


@pytest.fixture(scope="module")
def basis() -> Basis:
    return default_model().networks.basis


def glossy(basis: Basis, diffuse: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """f (N, P) of wide lobes over Lambertian surfaces, at the probe pairs."""
    numbers = np.tile(np.array(lobe.NO_LOBE), (COUNT, 1))
    numbers[:, 0], numbers[:, 1], numbers[:, 2] = np.linspace(0.2, 0.8, COUNT), normal, normal**0.5
    return lobe.f(numbers[:, None], *basis.pairs()) + diffuse[:, None] / np.pi


def test_the_functions_themselves(basis):
    """f U_k is the change of f by c_k."""
    source = glossy(basis, np.full(COUNT, 0.3), np.full(COUNT, 0.4))
    codes = solve_codes(basis, source)
    f = decode(codes[:, None], basis.probe_rows).astype(np.float64)
    changes = f[..., None] * basis.probe_rows[:, 1:]
    found = np.swapaxes(slopes(basis, f, codes), 1, 2) @ changes
    deviations = 1 / np.sqrt(np.diag(basis.prior))  # of the codes of the training materials
    found *= deviations / deviations[:, None]
    np.testing.assert_allclose(found, np.broadcast_to(np.eye(basis.size), found.shape), atol=0.02)


def test_brighter_surfaces_have_a_higher_gain(basis):
    """Whether a value is far below the mean or not."""
    f = glossy(basis, np.full(COUNT, 1e-4), np.full(COUNT, 0.4))
    codes = solve_codes(basis, f)
    by_factor = (f[..., None] * slopes(basis, f, codes)).sum(axis=1)
    expected = np.eye(basis.size)[[0] * COUNT]
    np.testing.assert_allclose(by_factor, expected, atol=0.01)


@pytest.mark.parametrize("changed", (0, 1))
def test_against_differences(basis, changed):
    """Of the diffuse and of the specular reflectance; codes decode to other values by some per
    cent, so that f changes by as little else."""
    values = np.linspace(0.2, 0.6, COUNT), np.linspace(0.6, 0.2, COUNT)
    step = 0.02 * np.eye(2)[changed]
    low, middle, high = (
        glossy(basis, *(x + way * s for x, s in zip(values, step, strict=True)))
        for way in (-1, 0, 1)
    )
    ends = [solve_codes(basis, f) for f in (low, high)]
    codes = solve_codes(basis, middle)
    found = np.einsum("npk,np->nk", slopes(basis, middle, codes), high - low)
    rows = basis.probe_rows
    of_slopes, of_ends = (
        decode(codes[:, None], rows) * (change @ rows[:, 1:].T)
        for change in (found, ends[1] - ends[0])
    )
    error = np.abs(of_slopes - of_ends) @ basis.measure / (np.abs(high - low) @ basis.measure)
    assert np.median(error) < 0.05
