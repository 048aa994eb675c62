"""`energy_compensation` of conductors and coats: all light, reciprocity, codes, what is refused."""

import dataclasses

import numpy as np
import pytest
from tests.directions import DOWN, above, at_cosines

import urushi
from urushi.checks import Widths
from urushi.core.anisotropic_albedos import surface_loss
from urushi.material import adding
from urushi.walk import analytic
from urushi.walk.simulate import albedo

COSINES = np.array([0.1, 0.4, 0.7, 1.0])
WI = at_cosines(COSINES)
GOLD = {"eta": (0.143, 0.375, 1.442), "k": (3.983, 2.386, 1.603)}


def conductor_albedo(compensated: bool = True, **options) -> np.ndarray:
    """Directional albedos of a conductor's first channel."""
    metal = urushi.conductor(**options, energy_compensation=compensated)
    cosines = np.array([0.05, 0.15, 0.3, 0.5, 0.7, 0.9, 1.0])
    return adding.albedos(lambda wi, wo: analytic.f(metal, wi, wo), cosines)[:, 0]


@pytest.mark.parametrize("alpha", [0.02, 0.08, 0.2, 0.45, 0.75, 1.0])
def test_a_white_conductor_reflects_all_light(alpha):
    """0.3 %: the albedo of single scattering is linear between the nodes of its table."""
    np.testing.assert_allclose(conductor_albedo(alpha=alpha, r0=1.0), 1, atol=3e-3)


def test_dark_facets_absorb_at_each_reflection():
    """Light that meets n facets keeps F^n, and F is 0.5 at the normal: at width 1 the second
    reflection of grey is F^2 of what white facets give back at most."""
    plain, given = (conductor_albedo(x, alpha=1.0, eta=1.0, k=2.0) for x in (False, True))
    assert np.all(given > plain)
    assert np.all(given - plain < 0.5 * (1 - conductor_albedo(False, alpha=1.0, r0=1.0)))


@pytest.mark.parametrize("widths", [{"alpha": 0.5}, {"alpha_u": 0.2, "alpha_v": 0.8}])
def test_a_conductor_is_reciprocal_and_gains(widths):
    plain, gold = (urushi.conductor(**widths, **GOLD, energy_compensation=x) for x in (False, True))
    wi, wo = above(4000, 1, 0.02), above(4000, 2, 0.02)
    f = analytic.f(gold, wi, wo)
    np.testing.assert_allclose(f, analytic.f(gold, wo, wi), rtol=2e-5, atol=1e-7)
    assert np.all(f >= analytic.f(plain, wi, wo))
    assert np.all(analytic.f(gold, wi * DOWN, wo) == 0)


def test_the_material_of_a_conductor_has_a_table_and_lies_under_coats():
    """The lobe of single scattering is analytic; what is given back is smooth, and fits the table
    and the code."""
    gold = urushi.conductor(0.6, **GOLD, energy_compensation=True)
    material = urushi.encode(gold)
    assert material.table is not None and material.beside_lobe
    wi, wo = above(2000, 5, 0.02), above(2000, 6, 0.02)
    expected = analytic.f(gold, wi, wo)
    np.testing.assert_allclose(material.f(wi, wo), expected, rtol=0.01)
    codes = dataclasses.replace(material, table=None, beside_lobe=False)
    assert np.median(np.abs(codes.f(wi, wo) / expected - 1)) < 0.01
    coated, plain = (
        urushi.encode(urushi.coat(metal, 0.05, ior=1.5)).directional_albedo(WI[-1:])
        for metal in (gold, urushi.conductor(0.6, **GOLD))
    )
    assert np.all(coated > 1.1 * plain)


#: Widths and media of white coats.
WHITE = [
    *({"alpha": x} | y for x in (0.1, 0.3, 1.0) for y in ({}, {"sigma_t": 1.0, "albedo": 1.0})),
    *({"alpha_u": u, "alpha_v": v} for u, v in ((0.8, 0.1), (0.05, 0.2))),
    *({"alpha": 0.3, "ior": ior} for ior in (0.6, 1.05, 3.0)),
]


@pytest.mark.parametrize("coat", WHITE)
def test_white_coats_reflect_all_light(coat):
    """At every azimuth, within 0.5 %, and five standard errors."""
    azimuth = np.radians([0.0, 0.0, 0.0, 0.0, 20.0, 70.0, 90.0, 0.0, 90.0])
    wi = at_cosines([*COSINES, 0.1, 0.1, 0.1, 0.6, 0.6], azimuth)
    options = {"ior": 1.5, "energy_compensation": True} | coat
    stack = urushi.coat(urushi.diffuse(1.0), **options)
    found, error = albedo(stack, wi, walks=1 << 14, seed=0)
    assert (np.abs(found - 1) < 0.005 + 5 * error).all()


@pytest.mark.parametrize("alpha", (0.1, 1.0))
@pytest.mark.parametrize("width", (0.02, 0.3))
def test_coats_over_white_metals_return_lost_light_and_gain_none(alpha, width):
    """Within 3 %, and five standard errors: the loss over a mirror is an estimate."""
    metal = urushi.conductor(width, 1.0)
    stacks = (urushi.coat(metal, alpha, ior=1.5, energy_compensation=x) for x in (True, False))
    (found, error), (without, _) = (albedo(x, WI, walks=1 << 14, seed=0) for x in stacks)
    assert (found < 1.03 + 5 * error).all()
    assert (without < found).all()


def test_the_integral_of_the_lobe_is_what_it_adds():
    """By quadrature over wo of what `simulate` gains, whose walks are the same without the lobe."""
    bottom = urushi.diffuse((0.9, 0.4, 0.1))
    stacks = [urushi.coat(bottom, 0.6, ior=1.5, energy_compensation=x) for x in (True, False)]
    nodes, weights = np.polynomial.legendre.leggauss(12)
    wo = at_cosines(0.5 * (nodes + 1))
    on, off = (urushi.simulate(stack, 0 * wo + WI[2], wo, walks=2)[0] for stack in stacks)
    integral = (np.pi * weights * wo[:, 2]) @ (on - off)
    walked = [albedo(stack, WI[2:3], walks=2)[0][0] for stack in stacks]
    np.testing.assert_allclose(integral, walked[0] - walked[1], rtol=0.01)


def test_surfaces_without_an_index_or_width_lose_nothing():
    assert not surface_loss(Widths(0.5, 0.5), 1.0)[0](WI).any()
    assert surface_loss(Widths(0.01, 0.01), 1.5)[0](WI[1:]).max() < 0.02


@pytest.mark.parametrize("fast", (False, True))
def test_materials_have_the_lobe_of_the_walk_and_files_hold_it(fast, tmp_path):
    """Within 1 % by transport and 5 % by the layering network, and five standard errors."""
    gold, top = urushi.conductor(0.3, (0.9, 0.7, 0.3)), urushi.dielectric(0.8, ior=1.5)
    options = {"color": (0.9, 0.6, 0.3), "energy_compensation": True}
    pairs, stack = (WI, np.flip(WI, 0) * [-1, 1, 1]), urushi.coat(gold, 0.8, ior=1.5, **options)
    f, error = urushi.simulate(stack, *pairs, walks=1 << 14)
    coated = urushi.layer(top, gold, fast=fast, **options)
    assert (np.abs(coated.f(*pairs) / f - 1) < (0.05 if fast else 0.01) + 5 * error / f).all()
    assert fast or coated == urushi.encode(stack)
    coated.save(tmp_path / "coated.safetensors")
    loaded = urushi.load(tmp_path / "coated.safetensors")
    assert (loaded.f(*pairs) == coated.f(*pairs)).all()
    twice, expected = (urushi.layer(top, x).f(*pairs) for x in (loaded, coated))
    np.testing.assert_allclose(twice, expected)
