"""The proxy's proposal: normalised, and sampled as it says."""

import numpy as np
import pytest
from fan2022.architecture import init
from fan2022.inference import MIN_SHARE, MIN_SIGMA, GaussianMixture, proxy
from tests import mixtures
from tests.directions import in_plane


@pytest.mark.parametrize(("sigma", "share"), [(0.1, 0.9), (0.5, 0.98), (1.0, 0.5)])
@pytest.mark.parametrize("degrees", [0, 50, 85])
def test_samples_follow_the_density(sigma, share, degrees, sphere_test):
    """Chi-squared over the whole sphere: normalisation included, nothing below the horizon."""
    mixture = GaussianMixture(np.float64(sigma), np.float64(share))
    wi = in_plane(degrees).astype(float)
    u = np.random.default_rng(6).random((100_000, 3))
    wo = mixtures.sample(mixture, wi[None], u)
    np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1, atol=1e-9)
    p = sphere_test(wo, lambda w: mixtures.pdf(mixture, wi[None], w.astype(float)))
    assert p > 1e-3 / 9  # nine tests


def test_widths_and_shares_stay_in_their_ranges():
    z = 100 * np.random.default_rng(7).normal(size=(500, 32)).astype(np.float32)
    sigma, share = proxy(init(0), z)
    assert (sigma >= MIN_SIGMA * 0.999).all() and (sigma <= 1).all()
    assert (share >= MIN_SHARE).all() and (share <= 1 - MIN_SHARE + 1e-6).all()
