"""Mixtures of GGX: facets by their definition, and densities that are those of the samples."""

import numpy as np
import pytest
from scipy import stats
from tests.directions import above, at_cosines
from tests.mixtures import pdf, sample
from tests.oracles import surfaces

from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.microfacet import of_widths
from urushi.core.mixture import Mixture
from urushi.core.quadrature import half_vector_rule

#: Two widths in both orders, with ratios up to 8, and narrow ones.
BRUSHED = [Widths(0.5, 0.1), Widths(0.1, 0.8), Widths(1.0, 0.7), Widths(0.02, 0.01)]


@pytest.mark.parametrize("alpha", [0.01, 0.1, 0.5, 1.0, *BRUSHED])
def test_distribution_and_masking_are_those_of_the_definition(jit, alpha):
    """In double precision. Both sides mask alike."""
    m, wi, wo = (above(2000, seed, 0.02) for seed in (1, 2, 3))
    expected = wi[:, 2] * wo[:, 2] * surfaces.facets(m, wi, wo, microfacet.pair(alpha))
    own, (m, wi, wo) = of_widths(jit.Float, alpha), (jit.Array3f(w.T) for w in (m, wi, wo))
    found = microfacet.ggx_d(m, own)
    found *= microfacet.smith_g1(wi, own) * microfacet.smith_g1(-wo, own)
    np.testing.assert_allclose(found.numpy(), expected, rtol=1e-5)


def test_pdf_integrates_to_one():
    """60 random mixtures, every third wi grazing down to cosine 0.001, every fifth alpha 0.01.

    By the rule of half vectors. What is left of its error comes from the ring where mirroring sets
    in: below 0.5 %.
    """
    rng = np.random.default_rng(23)
    for case in range(60):
        weights = rng.dirichlet([1, 1, 1]) if case % 4 else np.array([1.0, 0.0, 0.0])
        alphas = 0.01 ** rng.random(2)
        if case % 5 == 0:
            alphas[0] = 0.01
        cos_i = [rng.uniform(0, 1), 10 ** rng.uniform(-3, -1), 1.0][case % 3]
        wi = at_cosines([[cos_i]]).astype(np.float64)
        wo, solid_angles = half_vector_rule(wi[0])
        total = np.sum(solid_angles * pdf(Mixture(weights, alphas), wi, wo))
        assert abs(total - 1) < 5e-3, (weights, alphas, cos_i)


def test_float32_density_is_the_float64_density():
    # At the directions that float32 samples: the density of a lobe changes by its relative slope,
    # at most 4 / (alpha cos), times the rounding of wi + wo, 6e-8: 1 % at alpha = 0.01 and
    # cosines of 0.003.
    rng = np.random.default_rng(29)
    for alpha in (0.01, 0.1, 1.0):
        cos_i = rng.uniform(3e-3, 1, 5000)
        wi = at_cosines(cos_i)
        mixture = Mixture(np.array([0.8, 0.2], np.float32), np.array([alpha], np.float32))
        wo = sample(mixture, wi, rng.random((5000, 3), np.float32))
        single = pdf(mixture, wi, wo)
        mixture = Mixture(*(x.astype(np.float64) for x in mixture))
        double = pdf(mixture, wi.astype(np.float64), wo.astype(np.float64))
        assert single.dtype == np.float32
        np.testing.assert_allclose(single, double, rtol=1e-2)


@pytest.mark.parametrize("alphas", [((0.5, 0.15), (0.3, 0.9)), (0.2, 0.4), (1.0, 0.5)], ids=str)
@pytest.mark.parametrize(("theta", "phi"), [(0.1, 0.0), (0.8, 0.5), (1.5, np.pi / 2)])
def test_samples_follow_the_density(jit, sphere_test, alphas, theta, phi):
    u = np.random.default_rng(2).random((3, 200_000), dtype=np.float32)
    widths = [of_widths(jit.Float, Widths(*x) if isinstance(x, tuple) else x) for x in alphas]
    mixture = Mixture([jit.Float(share) for share in (0.5, 0.3, 0.2)], widths)
    wi = jit.Array3f(at_cosines([np.cos(theta)], phi).T)
    wo = mixture.sample(wi, jit.Float(u[0]), [jit.Float(x) for x in u[1:]])

    def density(v: np.ndarray) -> np.ndarray:
        return mixture.pdf(wi, jit.Array3f(np.ascontiguousarray(v.T))).numpy()

    assert sphere_test(wo.numpy().T, density) > 1e-4  # the smallest of nine


@pytest.mark.parametrize("alpha", [0.01, 0.03])
def test_slopes_of_narrow_lobes_follow_their_distribution(jit, alpha):
    """They are too narrow for cells on the sphere, so that Kolmogorov's test is of their normals.

    From straight above, visible normals have the density D cos, whose cumulative distribution in
    tan^2 / alpha^2 = t is t / (1 + t).
    """
    u = np.random.default_rng(2).random((2, 100_000), dtype=np.float32)
    up = jit.Array3f(0, 0, 1)
    m = microfacet.sample_visible_normal(up, jit.Float(alpha), *map(jit.Float, u)).numpy()
    t = (m[0] ** 2 + m[1] ** 2) / m[2] ** 2 / alpha**2
    assert stats.kstest(t, lambda x: x / (1 + x)).pvalue > 1e-3


def test_extreme_random_numbers_give_unit_directions():
    ends = np.array([0.0, 0.5, np.nextafter(np.float32(1), np.float32(0))], np.float32)
    u = np.stack(np.meshgrid(ends, ends, ends), axis=-1).reshape(-1, 3)
    mixture = Mixture([0.5, 0.5], [0.01])
    for cos_i in (1.0, 0.5, 1e-4):
        wi = at_cosines([cos_i] * len(u))
        wo = sample(mixture, wi, u)
        np.testing.assert_allclose(np.linalg.norm(wo, axis=1), 1, atol=1e-5)
        assert np.isfinite(pdf(mixture, wi, wo)).all()
