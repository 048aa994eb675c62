"""Distributions of parameters against analytic ones; bare bottoms are a lobe and a rest."""

import numpy as np
import pytest
from scipy import stats

from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError
from urushi.nets import lobe
from urushi.train import distribution
from urushi.train.distribution import Extended, Practical, bottom_lobes
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS

N = 20_000


def kolmogorov(values, cdf):
    """The p-value that `values` come from `cdf`; a fixed seed makes the 0.1 % level safe."""
    return stats.kstest(np.asarray(values, np.float64).ravel(), cdf).pvalue


def uniform_cdf(low, high):
    return lambda x: np.clip((x - low) / (high - low), 0, 1)


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
    assert kolmogorov(table.albedo, lambda x: 1 - np.sqrt(np.clip(1 - x, 0, 1))) > 1e-3
    assert kolmogorov(table.eta, uniform_cdf(1.05, 2)) > 1e-3
    assert kolmogorov(table.sigma_t, lambda x: np.sqrt(np.clip(x / 8, 0, 1))) > 1e-3


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


@pytest.mark.parametrize(
    ("indices", "cdf", "least"),
    [
        ("common", uniform_cdf(1.05, 2), 1.05),
        ("whole", whole_cdf, 0.5),
        ("low", uniform_cdf(0.5, 0.96), 0.5),
    ],
)
def test_indices_have_the_stated_distribution_at_every_interface(indices, cdf, least):
    """And change eta alone."""
    table = Extended(2, "dielectric", indices).sample(np.random.default_rng(0), N)
    for eta in (table.eta, table.bottom["eta"]):
        assert kolmogorov(eta, cdf) > 1e-3
        # In float32 an index of 0.996 is off by 3e-8.
        assert eta.min() >= np.float32(least) and np.abs(eta - 1).min() > 0.004 - 1e-6
    other = Extended(2, "dielectric").sample(np.random.default_rng(1), N)
    for name in ("alpha", "albedo", "sigma_t", "g"):
        both = getattr(table, name).ravel(), getattr(other, name).ravel()
        assert stats.ks_2samp(*both).pvalue > 1e-3, name


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


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ((6,), "coats is 6; choose one of 0, 1, 2, 3, 4, 5"),
        ((1, "velvet"), "bottom is 'velvet'; choose one of conductor"),
        ((1, "diffuse", "all"), "indices is 'all'; choose one of common, whole, low"),
    ],
)
def test_bad_descriptions_get_one_sentence(options, message):
    with pytest.raises(ParameterError, match=message):
        Extended(*options)


@pytest.mark.parametrize("kind", distribution.BOTTOMS)
def test_a_bottom_is_its_lobe_and_the_rest(kind):
    """A fitted lobe is above the bottom at some pairs, mostly by little."""
    assert "compensated" not in kind  # single scattering alone is drawn
    columns, pairs = Extended(1, kind).sample(np.random.default_rng(7), 24).bottom, probe_pairs()
    own, f = bottom_lobes(kind, columns), analytic.at_all(kind, columns, *pairs)
    top = lobe.f(own[:, None], *pairs)
    assert (np.median(np.maximum(top, f) / (f + 1e-3), axis=1) < 1.05).all()
    if KINDS[kind].family.bare:
        np.testing.assert_allclose(top, f, rtol=1e-2, atol=1e-5)  # rounding of sharp lobes
    if kind == "diffuse":
        assert not own[:, 1:4].any()
