"""GGX of one width or two: definition and sampling (also of mixtures, `test_mixture`)."""

import numpy as np
import pytest
from tests.directions import above

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.microfacet import of_widths

#: Two widths in both orders, with ratios up to 8, and narrow ones.
BRUSHED = [Widths(0.5, 0.1), Widths(0.1, 0.8), Widths(1.0, 0.7), Widths(0.02, 0.01)]
ALPHAS = [0.01, 0.1, 0.5, 1.0, *BRUSHED]


def direction(theta: float, phi: float = 0.4) -> np.ndarray:
    """A unit vector (3, 1)."""
    sin = np.sin(theta)
    return np.array([[sin * np.cos(phi)], [sin * np.sin(phi)], [np.cos(theta)]], np.float32)


def floats(jit, alpha):
    return of_widths(jit.Float, alpha)


@pytest.mark.parametrize("alpha", ALPHAS)
def test_distribution_and_masking_are_those_of_the_definition(jit, alpha) -> None:
    """Heitz 2014, eqs. 43, 72, 80 and 85, in angles and double precision."""
    w, (along, across) = above(2000, 1, 0.02).T, microfacet.pair(alpha)
    x, y, z = w.astype(np.float64)
    cos2_phi, sin2_phi = (c * c / (x * x + y * y) for c in (x, y))
    tan2 = (x * x + y * y) / z**2
    slope = tan2 * (cos2_phi / along**2 + sin2_phi / across**2)
    d = 1 / (np.pi * along * across * z**4 * (1 + slope) ** 2)
    towards = np.sqrt(cos2_phi * along**2 + sin2_phi * across**2)
    masking = 1 / (1 + (np.sqrt(1 + towards**2 * tan2) - 1) / 2)
    own, w = floats(jit, alpha), jit.Array3f(w)
    np.testing.assert_allclose(microfacet.ggx_d(w, own).numpy(), d, rtol=1e-5)
    np.testing.assert_allclose(microfacet.smith_g1(w, own).numpy(), masking, 1e-5)
    np.testing.assert_array_equal(
        microfacet.smith_g1(-w, own).numpy(), microfacet.smith_g1(w, own).numpy()
    )


@pytest.mark.parametrize("alpha", [0.01, 0.03])
def test_slopes_of_narrow_lobes_follow_their_distribution(jit, alpha: float) -> None:
    # From straight above visible normals have the density D cos, whose cumulative distribution in
    # tan^2 / alpha^2 = t is t / (1 + t): Kolmogorov's test, where cells would be too coarse.
    stats = pytest.importorskip("scipy.stats")
    u1, u2 = np.random.default_rng(2).random((2, 100_000), dtype=np.float32)
    w = jit.Array3f(direction(0.0))
    m = microfacet.sample_visible_normal(w, jit.Float(alpha), jit.Float(u1), jit.Float(u2)).numpy()
    t = (m[0] ** 2 + m[1] ** 2) / m[2] ** 2 / alpha**2
    assert stats.kstest(t, lambda x: x / (1 + x)).pvalue > 1e-3
