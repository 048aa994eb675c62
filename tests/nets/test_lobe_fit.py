"""Lobes that are fitted to values: known ones are found, and none exceeds its BRDF."""

import numpy as np
import pytest

from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import DARK, fit_lobes
from urushi.train.distribution import Extended
from urushi.walk import analytic


def values(kind: str) -> np.ndarray:
    """Values (128, P) of bottoms at the probe pairs."""
    bottom = Extended(0, kind).sample(np.random.default_rng(1), 128).bottom
    return analytic.at_all(kind, bottom, *probe_pairs())


def fitted(f: np.ndarray) -> np.ndarray:
    """Values of the fitted lobes."""
    return lobes.f(fit_lobes(f)[:, None], *probe_pairs())


def test_the_lobe_of_a_schlick_conductor_is_found():
    """Over a diffuse term, too: the approximation contains one, so that its error is zero here."""
    f = values("conductor")
    np.testing.assert_allclose(fitted(f), f, rtol=0.01, atol=DARK)
    np.testing.assert_allclose(fitted(f + 0.1), f, rtol=0.02, atol=2e-3)


def test_diffuse_and_black_surfaces_have_no_lobe():
    assert fit_lobes(values("diffuse"))[:, 1:4].max() < 1e-6
    assert fit_lobes(np.full((1, ANISOTROPIC_PROBES), 0.1), 2)[:, 1:3].max() < 1e-6
    assert not fit_lobes(np.zeros((2, 3, 192)))[..., 1:4].any()


@pytest.mark.parametrize("noise", [0.0, 0.01])
@pytest.mark.parametrize(
    "kind", ["conductor", "conductor_complex", "dielectric", "mixture", "measured_like"]
)
def test_lobes_do_not_exceed_the_brdf(kind, noise):
    """By relative error: what a lobe has too much, the networks cannot take away."""
    f = values(kind)
    top = fitted(f * (1 + noise * np.random.default_rng(2).standard_normal(f.shape)))
    excess = np.maximum(top - f, 0) / (f + DARK)
    assert excess.max() < 0.25
    assert excess.mean() < 0.002


@pytest.mark.parametrize("kind", ["conductor_complex", "dielectric"])
def test_interfaces_are_one_lobe(kind):
    """Schlick's term leaves a small part of the exact one, mostly at grazing angles."""
    f = values(kind)
    share = np.minimum(fitted(f), f).mean(axis=-1) / f.mean(axis=-1)
    assert np.median(share) > 0.9


def test_lobes_change_little_with_the_values():
    f = values("measured_like")
    change = np.abs(fitted(f * 1.001) - fitted(f)) / (f + DARK)
    assert np.median(change.max(axis=-1)) < 0.002


def test_a_brdf_has_the_same_lobe_to_the_bit_alone_and_among_others():
    """So that channels and texels do not depend on what else is encoded, nor on its layout."""
    f = values("measured_like")
    found = fit_lobes(f)
    np.testing.assert_array_equal(found, np.concatenate([fit_lobes(row[None]) for row in f]))
    np.testing.assert_array_equal(found, fit_lobes(np.asfortranarray(f)))  # as channels come last
    np.testing.assert_array_equal(found, fit_lobes(f.reshape(2, 64, -1)).reshape(128, -1))
    assert fit_lobes(f[:0].reshape(0, 3, f.shape[1])).shape == (0, 3, 6)


def test_fitted_lobes_of_two_widths_leave_a_diffuse_part():
    """Of BRDFs that are one lobe over a diffuse surface, the fitted numbers are exact."""
    rng = np.random.default_rng(9)
    u, v = rng.uniform(0.1, 0.8, (2, 20))
    normal, grazing, diffuse = rng.uniform(0.1, 0.6, (3, 20))
    own = np.stack(np.broadcast_arrays(u, normal, grazing, 0, 1.5, 0, v), axis=-1)
    pairs = (w.astype(np.float64) for w in probe_pairs(ANISOTROPIC_PROBES, 2))
    found = fit_lobes(lobes.f(own[:, None], *pairs) + diffuse[:, None] / np.pi, 2)
    np.testing.assert_allclose(found[:, [0, 1, 2, 6]], own[:, [0, 1, 2, 6]], rtol=0.02)
