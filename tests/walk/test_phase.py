"""The phase function: normalisation, mean cosine, and sampling by inversion."""

import numpy as np
import pytest

from urushi.walk import medium

NODES = np.polynomial.legendre.leggauss(200)
ASYMMETRIES = [-0.95, -0.5, -1e-3, -1e-6, 0.0, 1e-8, 9.9e-4, 1.01e-3, 0.3, 0.8, 0.97]


def cumulative(g: float, cos: np.ndarray) -> np.ndarray:
    """The exact distribution function of the cosine, in float64."""
    cos = cos.astype(np.float64)
    if abs(g) < 1e-5:  # the closed form is 0 / 0; first order in g
        return (1 + cos) / 2 - 0.75 * g * (1 - cos**2)
    # (1 - g^2) / 2g (1/s - 1/(1+g)) without cancelling at small g
    s = np.sqrt(1 + g * g - 2 * g * cos)
    return (1 - g * g) * (1 + cos) / (s * (1 + g) * (1 + g + s))


@pytest.mark.parametrize("g", ASYMMETRIES)
def test_it_is_normalised_and_its_mean_cosine_is_g(jit, g: float) -> None:
    nodes, weights = NODES
    values = medium.hg(jit.Float(nodes.astype(np.float32)), jit.Float(g)).numpy()
    # float32 cosines and a peak that is sharp for the largest |g|
    assert 2 * np.pi * np.sum(values * weights) == pytest.approx(1, abs=1e-4)
    assert 2 * np.pi * np.sum(values * weights * nodes) == pytest.approx(g, abs=1e-4)


@pytest.mark.parametrize("g", ASYMMETRIES)
def test_samples_invert_the_distribution_function(jit, g: float) -> None:
    u = np.concatenate([[0, 2**-24, 1 - 2**-24], np.linspace(0, 1, 1001)[:-1]]).astype(np.float32)
    cos = medium.sample_hg_cosine(jit.Float(g), jit.Float(u)).numpy()
    assert np.all(np.abs(cos) <= 1)
    # Near the switch to the expansion the closed form loses 1e-7 / 2e-3 = 6e-5 to cancellation; at
    # |g| = 0.97 the density of cosines reaches 1100, and float32 cosines are 6e-8 apart.
    np.testing.assert_allclose(cumulative(g, cos), u, atol=1.5e-4)
