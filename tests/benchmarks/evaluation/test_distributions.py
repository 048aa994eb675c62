"""Distributions of parameters against the analytic ones of Table 2 (Fan et al. 2022)."""

import numpy as np
import pytest
from benchmarks.evaluation.distributions import Clear, Table2, anisotropic, to_dict
from scipy import stats

from urushi.train.distribution import Extended

N = 20_000


def kolmogorov(values, cdf):
    """The p-value that `values` come from `cdf`; a fixed seed makes the 0.1 % level safe."""
    return stats.kstest(np.asarray(values, np.float64).ravel(), cdf).pvalue


def uniform_cdf(low, high):
    return lambda x: np.clip((x - low) / (high - low), 0, 1)


TABLE_2 = {
    "alpha": lambda x: uniform_cdf(0.216, 1)(np.cbrt(x)),
    "eta": uniform_cdf(1.05, 2),
    "albedo": lambda x: 1 - np.sqrt(np.clip(1 - x, 0, 1)),
    "r0": uniform_cdf(0, 1),
}


@pytest.mark.parametrize("coats", [1, 3])
def test_table_2_has_the_papers_distributions(coats):
    table = Table2(coats).sample(np.random.default_rng(0), N)
    assert table.kind == "conductor"
    assert table.alpha.shape == (N, coats)
    for name in ("alpha", "eta", "albedo"):
        assert kolmogorov(getattr(table, name)[:, -1], TABLE_2[name]) > 1e-3, name
    for name in ("alpha", "r0"):
        assert kolmogorov(table.bottom[name], TABLE_2[name]) > 1e-3, name
    values, counts = np.unique(table.sigma_t, return_counts=True)
    np.testing.assert_array_equal(values, [0, 1, 2, 5])
    assert stats.chisquare(counts).pvalue > 1e-3
    assert (table.g == 0).all()


def test_clear_coats_are_extended_coats_with_thin_or_no_media():
    clear = Clear(2, "conductor_complex").sample(np.random.default_rng(0), N)
    extended = Extended(2, "conductor_complex").sample(np.random.default_rng(1), N)
    assert clear.kind == extended.kind
    for name in ("alpha", "eta", "albedo", "g"):
        both = getattr(clear, name).ravel(), getattr(extended, name).ravel()
        assert stats.ks_2samp(*both).pvalue > 1e-3, name
    assert stats.binomtest(int((clear.sigma_t == 0).sum()), clear.sigma_t.size).pvalue > 1e-3
    assert kolmogorov(clear.sigma_t[clear.sigma_t > 0], uniform_cdf(0, 0.3)) > 1e-3


def test_table_2_has_the_moments_of_its_formulas():
    table = Table2().sample(np.random.default_rng(1), N)
    # E[U(a, 1)^3] = (1 - a^4) / (4 (1 - a)); E[1 - U^2] = 2/3; tolerance: 4 standard errors.
    alpha = (1 - 0.216**4) / (4 * (1 - 0.216))
    for values, mean in ((table.alpha, alpha), (table.albedo, 2 / 3), (table.sigma_t, 2)):
        assert abs(values.mean() - mean) < 4 * values.std() / np.sqrt(N)


def test_parameters_of_different_coats_are_independent():
    table = Table2(2).sample(np.random.default_rng(0), N)
    for name in ("alpha", "eta", "albedo", "sigma_t"):
        values = getattr(table, name)
        assert abs(np.corrcoef(values[:, 0], values[:, 1])[0, 1]) < 4 / np.sqrt(N)


def test_descriptions_from_before_the_choice_of_indices_mean_common_ones():
    old = {"kind": "extended", "coats": 2, "bottom": "diffuse"}
    assert to_dict(Extended(2, "diffuse")) == old


def test_two_widths_have_quotients_to_eight_along_either_axis():
    table = anisotropic(np.random.default_rng(0), N, 1, "conductor_anisotropic")
    for u, v in ((table.alpha.u[:, 0], table.alpha.v[:, 0]), [*table.bottom.values()][:2]):
        inside = (np.minimum(u, v) > 0.0101) & (np.maximum(u, v) < 0.999)  # others are clipped
        logs = np.log(u / v)[inside] / np.log(8)
        assert np.abs(logs).max() < 1 + 1e-5
        assert abs((logs > 0).mean() - (logs < 0).mean()) < 4 / np.sqrt(N)
