"""Distributions of parameters against the analytic ones of Table 2 (Fan et al. 2022)."""

import numpy as np
import pytest
from scipy import stats

from urushi.errors import ParameterError
from urushi.train import distribution
from urushi.train.distribution import Clear, Extended, Practical, Table2

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


@pytest.mark.parametrize("bottom", distribution.BOTTOMS)
def test_extended_stays_within_its_ranges_and_fills_them(bottom):
    table = Extended(2, bottom).sample(np.random.default_rng(0), N)
    ranges = {"alpha": (0.01, 1), "eta": (1.05, 2), "albedo": (0, 1), "sigma_t": (0, 8)}
    for name, (low, high) in {**ranges, "g": (-0.8, 0.9)}.items():
        values = getattr(table, name)
        assert low <= values.min() <= low + 0.02 * (high - low), name
        assert high - 0.02 * (high - low) <= values.max() <= high, name
    for name, values in table.bottom.items():
        assert values.shape == (N,)
        assert values.min() >= 0, name
    assert kolmogorov(table.g, uniform_cdf(-0.8, 0.9)) > 1e-3
    assert kolmogorov(table.sigma_t, lambda x: np.sqrt(np.clip(x / 8, 0, 1))) > 1e-3


def test_bottoms_without_a_coat_are_a_distribution_too():
    table = Extended(0, "dielectric").sample(np.random.default_rng(0), 10)
    assert (len(table), table.coats) == (10, 0)


def whole_cdf(x):
    """The mixture over [0.5, 3] that the documentation states."""
    x = np.asarray(x)

    def near(distance):
        return np.clip(np.log(np.maximum(distance, 1e-9) / 0.004) / np.log(0.05 / 0.004), 0, 1)

    return (
        0.55 * uniform_cdf(1.05, 2)(x)
        + 0.1 * uniform_cdf(2, 3)(x)
        + 0.25 * uniform_cdf(0.5, 0.96)(x)
        + 0.05 * (np.where(x < 1, 1 - near(1 - x), 1) + near(x - 1))
    )


@pytest.mark.parametrize("make", [Extended, Clear])
def test_whole_indices_have_the_stated_mixture_on_both_sides_of_one(make):
    table = make(2, "dielectric", "whole").sample(np.random.default_rng(0), N)
    for eta in (table.eta, table.bottom["eta"]):
        assert kolmogorov(eta, whole_cdf) > 1e-3
        # In float32 an index of 0.996 is off by 3e-8.
        assert eta.min() >= 0.5 and eta.max() <= 3 and np.abs(eta - 1).min() > 0.004 - 1e-6


def test_indices_change_eta_alone():
    common = Extended(1, "dielectric").sample(np.random.default_rng(0), N)
    whole = Extended(1, "dielectric", "whole").sample(np.random.default_rng(1), N)
    assert kolmogorov(common.bottom["eta"], TABLE_2["eta"]) > 1e-3
    for name in ("alpha", "albedo", "sigma_t", "g"):
        both = getattr(common, name).ravel(), getattr(whole, name).ravel()
        assert stats.ks_2samp(*both).pvalue > 1e-3, name
    assert stats.ks_2samp(common.bottom["alpha"], whole.bottom["alpha"]).pvalue > 1e-3


@pytest.mark.parametrize("make", [Extended, Clear])
def test_low_indices_are_below_one_at_every_interface(make):
    table = make(2, "dielectric", "low").sample(np.random.default_rng(0), N)
    for eta in (table.eta, table.bottom["eta"]):
        assert kolmogorov(eta, uniform_cdf(0.5, 0.96)) > 1e-3
        assert eta.min() >= 0.5 and eta.max() < 1


def test_practical_coats_have_absolute_indices_with_gaps_of_air():
    table = Practical(3, "conductor_complex").sample(np.random.default_rng(0), N)
    index = np.cumprod(table.eta.astype(np.float64), axis=1)
    gap = np.abs(index - 1) < 1e-6
    assert not gap[:, 0].any() and not (gap[:, 1] & gap[:, 2]).any()
    assert (table.sigma_t[gap] == 0).all()
    solid = (index[:, 0] < 2) & ~gap[:, 0]
    assert abs(gap[solid, 1].mean() - 0.2) < 4 * np.sqrt(0.16 / solid.sum())
    below = gap[:, 1]
    assert index[below, 2].min() >= 1.3 - 1e-6 and index[below, 2].max() <= 1.8 + 1e-6
    ratio = table.eta[~gap[:, 1], 1]
    assert ratio.min() > 0.8 - 1e-6 and ratio.max() < 1.3 + 1e-6
    # k was U(0.5, 8) before its division by the index above.
    assert kolmogorov(table.bottom["k"] * index[:, 2], uniform_cdf(0.5, 8)) > 1e-3


def test_practical_media_are_clear_tinted_lossless_or_any():
    table = Practical(1, "diffuse").sample(np.random.default_rng(0), N)
    clear, tinted, lossless = table.sigma_t == 0, table.albedo == 0, table.albedo == 1
    for chosen, share in ((clear, 0.4), (tinted, 0.2), (lossless, 0.1)):
        assert abs(chosen.mean() - share) < 4 * np.sqrt(share * (1 - share) / N)


def test_descriptions_from_before_the_choice_of_indices_mean_common_ones():
    old = {"kind": "extended", "coats": 2, "bottom": "diffuse"}
    assert distribution.to_dict(Extended(2, "diffuse")) == old


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Table2(6), "coats is 6; it must be an integer from 0 to 5"),
        (lambda: Extended(1, "velvet"), "bottom is 'velvet'; choose one of conductor"),
        (
            lambda: Extended(1, "diffuse", "all"),
            "indices is 'all'; choose one of common, whole, low",
        ),
    ],
)
def test_bad_descriptions_get_one_sentence(make, message):
    with pytest.raises(ParameterError, match=message):
        make()
