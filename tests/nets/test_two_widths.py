"""Codes of two GGX widths: symmetries to the bit, the proposal's density, fits of lobes."""

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.checks import Widths
from urushi.core.direction_sets import cosine_pairs, slope_pairs
from urushi.core.probe_pairs import ANISOTROPIC_PROBES, probe_pairs
from urushi.nets import lobe, proposal
from urushi.nets.interface_fit import find_lobes
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.networks import Networks

#: Mirror images at the xz plane and at the yz plane, and half a turn.
MIRRORS = np.array([[1, -1, 1], [-1, 1, 1], [-1, -1, 1]], np.float32)


@pytest.fixture(scope="module")
def networks() -> Networks:
    return untrained(widths=2, probes=ANISOTROPIC_PROBES).networks


def lobes(count: int, rng: np.random.Generator) -> np.ndarray:
    """Lobes (N, 7) of dielectrics and metals with widths from 0.03 to 1."""
    u, v = np.exp(rng.uniform(np.log(0.03), 0, (2, count)))
    zero, one = np.zeros(count), np.ones(count)
    exact = np.stack([u, zero, zero, one, rng.uniform(0.5, 3, count), zero, v], axis=-1)
    metal = np.stack([u, rng.random(count), one, zero, 1.5 * one, zero, v], axis=-1)
    return np.where((np.arange(count) % 2 == 0)[:, None], exact, metal)


def codes(networks: Networks, count: int, seed: int = 1) -> np.ndarray:
    """Codes float32 (N, L)."""
    rng = np.random.default_rng(seed)
    rest = rng.normal(size=(count, networks.arch.latent - networks.arch.lobe))
    return np.concatenate([lobes(count, rng), rest], axis=-1).astype(np.float32)


def pairs(count: int = 3000) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(3)
    parts = cosine_pairs(rng, count // 2), slope_pairs(rng, count - count // 2)
    wi, wo = (np.concatenate(sides) for sides in zip(*parts, strict=True))
    return wi, wo


def test_mirror_images_exchange_and_half_turns_give_the_same_bits(networks):
    wi, wo = pairs()
    z = codes(networks, len(wi))
    f = networks.f(z, wi, wo)
    np.testing.assert_array_equal(f, networks.f(z, wo, wi))
    for mirror in MIRRORS:
        np.testing.assert_array_equal(f, networks.f(z, wi * mirror, wo * mirror))
    quarter = (
        np.stack([-wi[:, 1], wi[:, 0], wi[:, 2]], -1),
        np.stack([-wo[:, 1], wo[:, 0], wo[:, 2]], -1),
    )
    assert np.median(np.abs(networks.f(z, *quarter) / f - 1)) > 0.05  # they see the azimuth


def test_exchanging_the_widths_turns_a_lobe_by_a_quarter():
    wi, wo = pairs()
    z = lobes(len(wi), np.random.default_rng(2))
    exchanged = z[:, [6, 1, 2, 3, 4, 5, 0]]
    turned = (np.stack([-w[:, 1], w[:, 0], w[:, 2]], axis=-1) for w in (wi, wo))
    # Rounding of wi + wo over the narrowest width, squared.
    np.testing.assert_allclose(lobe.f(exchanged, *turned), lobe.f(z, wi, wo), rtol=1e-4)


def test_two_equal_widths_are_one():
    """Up to the rounding of unit vectors in single precision."""
    wi, wo = (w.astype(np.float64) for w in pairs())
    z = lobes(len(wi), np.random.default_rng(2))
    z[:, 6] = z[:, 0]
    np.testing.assert_allclose(lobe.f(z, wi, wo), lobe.f(z[:, :6], wi, wo), rtol=1e-6)
    alphas = np.random.default_rng(3).uniform(0.05, 1, (len(wi), 3))
    weights = np.full((len(wi), 4), 0.25)
    np.testing.assert_allclose(
        proposal.mixture_pdf(weights, Widths(alphas, alphas), wi, wo),
        proposal.mixture_pdf(weights, alphas, wi, wo),
        rtol=1e-6,
    )


@pytest.mark.parametrize("wi", [(0.0, 0.0), (0.6, 0.3), (-0.3, 0.9), (0.1, -0.99)])
def test_the_proposals_density_is_that_of_its_samples(networks, wi):
    """Means over samples of smooth functions agree with integrals of the density."""
    wi = np.array([*wi, np.sqrt(max(1 - wi[0] ** 2 - wi[1] ** 2, 1e-4))], np.float32)
    wi /= np.linalg.norm(wi)
    rng = np.random.default_rng(4)
    mixture = networks.proposal(codes(networks, 1), wi)
    count = 1 << 18
    wo = proposal.sample_mixture(*mixture, wi, rng.random((count, 3)).astype(np.float32))
    assert (wo[:, 2] >= 0).all()
    # Midpoints in both angles: cells of 2 by 4 milliradians, for lobes of at least 30.
    theta = 0.5 * np.pi * (np.arange(800) + 0.5) / 800
    theta, phi = np.meshgrid(theta, 2 * np.pi * (np.arange(1600) + 0.5) / 1600)
    sin = np.sin(theta)
    grid = np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)], axis=-1).reshape(-1, 3)
    density = proposal.mixture_pdf(*mixture, wi, grid) * (sin.ravel() * np.pi**2 / len(grid))
    assert density.sum() == pytest.approx(1, abs=0.01)
    for moment in (lambda w: w[:, 0] ** 2, lambda w: w[:, 1] ** 2, lambda w: w[:, 0] * w[:, 1]):
        samples = moment(wo)
        error = 5 * samples.std() / np.sqrt(count) + 0.005  # of the grid
        assert abs(samples.mean() - (moment(grid) * density).sum()) < error


def test_lobes_are_recovered_from_values():
    """A surface that is a lobe: by Schlick's term, and with the exact term of metal or glass."""
    wi, wo = (w.astype(np.float64) for w in probe_pairs(ANISOTROPIC_PROBES, 2))
    z = lobes(24, np.random.default_rng(7))
    z[:, 4] = np.where(z[:, 3] > 0, np.random.default_rng(8).uniform(1.2, 2.5, 24), z[:, 4])
    z = np.concatenate([z, [[0.3, 0, 0, 1, 0.2, 3.9, 0.06]]])
    f = lobe.f(z[:, None], wi, wo)
    found = find_lobes(f, 2)
    again = lobe.f(found[:, None].astype(np.float64), wi, wo)
    assert np.abs(again / f - 1).max() < 0.01
    np.testing.assert_allclose(found[:, [0, 6]], z[:, [0, 6]], rtol=5e-3)


def test_a_fitted_lobe_leaves_a_diffuse_part_and_hardly_exceeds_f():
    wi, wo = (w.astype(np.float64) for w in probe_pairs(ANISOTROPIC_PROBES, 2))
    top = lobe.f(np.array([0.3, 0.4, 1, 0, 1.5, 0, 0.08]), wi, wo)
    found = fit_lobes(top[None] + 0.2 / np.pi, 2)
    assert found.shape == (1, 7)
    np.testing.assert_allclose(found[0, [0, 1, 6]], [0.3, 0.4, 0.08], rtol=0.01)
    assert fit_lobes(np.full((1, ANISOTROPIC_PROBES), 0.1), 2)[:, 1:3].max() < 1e-6


def test_fitted_lobes_follow_the_values():
    """Of BRDFs that are one lobe over a diffuse surface, the fitted numbers are exact."""
    wi, wo = (w.astype(np.float64) for w in probe_pairs(ANISOTROPIC_PROBES, 2))
    rng = np.random.default_rng(9)
    u, v = rng.uniform(0.1, 0.8, (2, 20))
    normal, grazing, diffuse = rng.uniform(0.1, 0.6, (3, 20))
    zero = np.zeros(20)
    numbers = np.stack([u, normal, grazing, zero, zero + 1.5, zero, v], axis=-1)
    f = lobe.f(numbers[:, None], wi, wo) + diffuse[:, None] / np.pi
    fitted = fit_lobes(f, 2)
    np.testing.assert_allclose(fitted[:, [0, 1, 2, 6]], numbers[:, [0, 1, 2, 6]], rtol=0.02)
