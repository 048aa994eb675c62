"""Lobes that are fitted to values: known ones are found, and none exceeds its BRDF."""

import numpy as np
import pytest

from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import DARK, fit_lobes
from urushi.train.distribution import Extended
from urushi.walk import analytic

STACKS = 128


def values(kind: str) -> np.ndarray:
    """Values (`STACKS`, P) of bottoms at the probe pairs."""
    wi, wo = probe_pairs()
    columns = Extended(0, kind).sample(np.random.default_rng(1), STACKS).bottom
    row = np.repeat(np.arange(STACKS, dtype=np.uint32), len(wi))
    directions = (np.tile(w, (STACKS, 1)) for w in (wi, wo))
    return analytic.rows(kind, columns, row, *directions).reshape(STACKS, -1)


def fitted(f: np.ndarray) -> np.ndarray:
    """Values of the fitted lobes."""
    return lobes.f(fit_lobes(f)[:, None], *probe_pairs())


def test_lobe_of_a_schlick_conductor_is_found():
    f = values("conductor")
    np.testing.assert_allclose(fitted(f), f, rtol=0.01, atol=DARK)


def test_lobe_over_a_diffuse_term_is_found():
    """The approximation contains a diffuse term, so that its error is zero here too."""
    lobe = values("conductor")
    np.testing.assert_allclose(fitted(lobe + 0.1), lobe, rtol=0.02, atol=2e-3)


def test_diffuse_surfaces_have_no_lobe():
    assert fit_lobes(values("diffuse"))[:, 1:4].max() < 1e-6


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


def test_black_surfaces_and_leading_axes():
    assert not fit_lobes(np.zeros((2, 3, 192)))[..., 1:4].any()
    f = values("conductor")[:6]
    np.testing.assert_array_equal(fit_lobes(f.reshape(2, 3, -1)).reshape(6, -1), fit_lobes(f))


def test_a_brdf_has_the_same_lobe_to_the_bit_alone_and_among_others():
    """So that channels and texels do not depend on what else is encoded."""
    f = values("measured_like")
    alone = np.concatenate([fit_lobes(row[None]) for row in f])
    np.testing.assert_array_equal(fit_lobes(f), alone)
    np.testing.assert_array_equal(fit_lobes(np.asfortranarray(f)), alone)  # as channels come last


def test_no_brdfs_have_no_lobes():
    assert fit_lobes(np.zeros((0, 3, len(probe_pairs()[0])))).shape == (0, 3, 6)


def of_two_widths(*numbers) -> tuple[np.ndarray, np.ndarray]:
    """Lobes (N, 7) of columns, and their values (N, P) at the probe pairs of two widths."""
    own = np.stack(np.broadcast_arrays(*numbers), axis=-1)
    pairs = (w.astype(np.float64) for w in probe_pairs(ANISOTROPIC_PROBES, 2))
    return own, lobes.f(own[:, None], *pairs)


def test_fitted_lobes_of_two_widths_leave_a_diffuse_part():
    """Of BRDFs that are one lobe over a diffuse surface, the fitted numbers are exact."""
    rng = np.random.default_rng(9)
    u, v = rng.uniform(0.1, 0.8, (2, 20))
    normal, grazing, diffuse = rng.uniform(0.1, 0.6, (3, 20))
    numbers, f = of_two_widths(u, normal, grazing, 0, 1.5, 0, v)
    fitted = fit_lobes(f + diffuse[:, None] / np.pi, 2)
    np.testing.assert_allclose(fitted[:, [0, 1, 2, 6]], numbers[:, [0, 1, 2, 6]], rtol=0.02)
    assert fit_lobes(np.full((1, ANISOTROPIC_PROBES), 0.1), 2)[:, 1:3].max() < 1e-6
