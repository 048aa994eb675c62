"""Conductors with energy compensation: all light, reciprocity, sampling, encoding."""

import dataclasses

import drjit as dr
import numpy as np
import pytest
from tests.directions import above

import urushi
from urushi.core.random import stream
from urushi.material import adding
from urushi.walk import analytic, monte_carlo
from urushi.walk.bottoms import KINDS
from urushi.walk.table import from_stack, table_bottom

COSINES = np.array([0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 1.0])

GOLD = {"eta": (0.143, 0.375, 1.442), "k": (3.983, 2.386, 1.603)}


@pytest.mark.parametrize("alpha", [0.02, 0.08, 0.2, 0.45, 0.75, 1.0])
def test_a_white_conductor_reflects_all_light(alpha):
    """0.3 %: the albedo of single scattering is linear between the nodes of its table."""
    white = urushi.conductor(alpha, r0=1.0, energy_compensation=True)
    found = adding.albedos(lambda wi, wo: analytic.f(white, wi, wo), COSINES)
    np.testing.assert_allclose(found, 1, atol=3e-3)


def test_dark_facets_absorb_at_each_reflection():
    """Light that meets n facets keeps F^n: at width 1 the second reflection of grey is F^2 of what
    white facets give back at most."""
    plain, given = (
        analytic_albedo(urushi.conductor(1.0, eta=1.0, k=2.0, energy_compensation=on))
        for on in (False, True)
    )  # F is 0.5 at the normal
    lost = 1 - analytic_albedo(urushi.conductor(1.0, r0=1.0))
    assert np.all(given > plain)
    assert np.all(given - plain < 0.5 * lost)


def analytic_albedo(surface):
    return adding.albedos(lambda wi, wo: analytic.f(surface, wi, wo), COSINES)[:, 0]


@pytest.mark.parametrize("widths", [{"alpha": 0.5}, {"alpha_u": 0.2, "alpha_v": 0.8}])
def test_it_is_reciprocal(widths):
    gold = urushi.conductor(**widths, **GOLD, energy_compensation=True)
    wi, wo = above(4000, 1, 0.02), above(4000, 2, 0.02)
    np.testing.assert_allclose(
        analytic.f(gold, wi, wo), analytic.f(gold, wo, wi), rtol=2e-5, atol=1e-7
    )
    assert np.all(
        analytic.f(gold, wi, wo) >= analytic.f(urushi.conductor(**widths, **GOLD), wi, wo)
    )
    assert np.all(analytic.f(gold, wi * [1, 1, -1], wo) == 0)


@pytest.mark.parametrize("widths", [{"alpha": 0.6}, {"alpha_u": 0.3, "alpha_v": 0.9}])
@pytest.mark.parametrize("theta", [0.2, 1.3])
def test_samples_follow_their_density(widths, theta):
    """The mean weight is the albedo: of white facets of one width or two, all light."""
    device = monte_carlo.backend()
    white = urushi.conductor(**widths, r0=1.0, energy_compensation=True)
    rng = stream(device.PCG32, dr.arange(device.UInt64, 1 << 18), 1)
    row = dr.zeros(device.UInt32, 1 << 18)
    bottom = table_bottom(device, from_stack(white), row)
    wi = device.Array3f(
        float(np.sin(theta) * 0.8), float(np.sin(theta) * 0.6), float(np.cos(theta))
    )
    wi += dr.zeros(device.Array3f, 1 << 18)
    wo, weight, pdf = bottom.sample(wi, *(rng.next_float32() for _ in range(3)))
    _f, density = bottom.f_pdf(wi, wo)
    np.testing.assert_allclose(pdf.numpy(), density.numpy(), rtol=1e-5)
    weight = weight.numpy().astype(float)
    tolerance = 5 * weight.std() / len(weight) ** 0.5 + 3e-3
    assert weight.mean() == pytest.approx(1, abs=tolerance)


def test_a_walk_sees_it_below_an_absent_coat():
    gold = urushi.conductor(0.6, **GOLD, energy_compensation=True)
    wi, wo = above(64, 3, 0.02), above(64, 4, 0.02)
    stack = urushi.coat(gold, 0.1, eta=1.0)
    f, se = urushi.simulate(stack, wi, wo, walks=1 << 12, progress=False)
    expected = analytic.f(gold, wi, wo)
    np.testing.assert_array_less(np.abs(f - expected), 5 * se + 1e-4 * expected + 1e-6)


def test_its_material_has_a_table_and_lies_under_coats():
    """The lobe of single scattering is analytic; what is given back is smooth, and fits the table
    and the code."""
    gold = urushi.conductor(0.6, **GOLD, energy_compensation=True)
    material = urushi.encode(gold)
    assert material.table is not None and material.beside_lobe
    wi, wo = above(2000, 5, 0.02), above(2000, 6, 0.02)
    expected = analytic.f(gold, wi, wo)
    np.testing.assert_allclose(material.f(wi, wo), expected, rtol=0.01)
    codes = dataclasses.replace(material, table=None, beside_lobe=False)
    error = np.abs(codes.f(wi, wo) - expected) / expected
    assert np.median(error) < 0.01
    coated = urushi.encode(urushi.coat(gold, 0.05, ior=1.5))
    plain = urushi.encode(urushi.coat(urushi.conductor(0.6, **GOLD), 0.05, ior=1.5))
    up = np.array([[0.0, 0.0, 1.0]])
    assert np.all(coated.directional_albedo(up) > 1.1 * plain.directional_albedo(up))


def test_training_draws_kinds_of_single_scattering_alone():
    from urushi.train.distribution import BOTTOMS

    assert not [name for name in BOTTOMS if "compensated" in name]
    assert {"conductor_compensated", "conductor_complex_compensated_anisotropic"} <= set(KINDS)
