"""`energy_compensation` of described coats: the white furnace, the codes, and what is refused."""

import numpy as np
import pytest

import urushi
from urushi.checks import Widths
from urushi.core.anisotropic_albedos import surface_loss
from urushi.errors import ParameterError
from urushi.walk.simulate import albedo

COSINES = np.array([0.1, 0.4, 0.7, 1.0])
WI = np.stack([np.sqrt(1 - COSINES**2), 0 * COSINES, COSINES], axis=-1)


#: Widths and media of white coats.
WHITE = [
    *({"alpha": x} | y for x in (0.1, 0.3, 1.0) for y in ({}, {"sigma_t": 1.0, "albedo": 1.0})),
    *({"alpha_u": u, "alpha_v": v} for u, v in ((0.8, 0.1), (0.05, 0.2))),
]


@pytest.mark.parametrize("coat", WHITE)
def test_white_coats_reflect_all_light(coat):
    """At every azimuth, within 0.5 %, and five standard errors."""
    azimuth = np.radians([0.0, 0.0, 0.0, 0.0, 20.0, 70.0, 90.0, 0.0, 90.0])
    cosine = np.array([*COSINES, 0.1, 0.1, 0.1, 0.6, 0.6])
    sine = np.sqrt(1 - cosine**2)
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1)
    stack = urushi.coat(urushi.diffuse(1.0), ior=1.5, energy_compensation=True, **coat)
    found, error = albedo(stack, wi, walks=1 << 14, seed=0)
    assert (np.abs(found - 1) < 0.005 + 5 * error).all()


@pytest.mark.parametrize("alpha", (0.1, 1.0))
@pytest.mark.parametrize("width", (0.02, 0.3))
def test_coats_over_white_metals_return_lost_light_and_gain_none(alpha, width):
    """Within 3 %, and five standard errors: the loss over a mirror is an estimate."""
    on, off = (
        urushi.coat(urushi.conductor(width, 1.0), alpha, ior=1.5, energy_compensation=x)
        for x in (True, False)
    )
    found, error = albedo(on, WI, walks=1 << 14, seed=0)
    without, _ = albedo(off, WI, walks=1 << 14, seed=0)
    assert (found < 1.03 + 5 * error).all()
    assert (without < found).all()


def test_the_integral_of_the_lobe_is_what_it_adds():
    """By quadrature over wo of what `simulate` gains, whose walks are the same without the lobe."""
    options = {"alpha": 0.6, "ior": 1.5}
    on, off = (
        urushi.coat(urushi.diffuse((0.9, 0.4, 0.1)), **options, energy_compensation=x)
        for x in (True, False)
    )
    nodes, weights = np.polynomial.legendre.leggauss(12)
    cosines = 0.5 * (nodes + 1)
    wo = np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1)
    wi = np.tile(WI[2], (len(wo), 1))
    gained = urushi.simulate(on, wi, wo, walks=2)[0] - urushi.simulate(off, wi, wo, walks=2)[0]
    integral = (np.pi * weights * cosines) @ gained
    walked = [albedo(stack, WI[2:3], walks=2)[0][0] for stack in (on, off)]
    np.testing.assert_allclose(integral, walked[0] - walked[1], rtol=0.01)


@pytest.mark.parametrize("mirrored", (0.0, 1.0))
@pytest.mark.parametrize("alpha", (0.02, 0.3, 0.9))
def test_the_mean_loss_is_the_mean_of_the_losses(alpha, mirrored):
    """Within what tables add, linear between nodes: the lobe gives back what is lost."""
    for eta in (0.6, 1.05, 1.5, 3.0):
        lost, mean = surface_loss(Widths(alpha, alpha), eta, mirrored)
        nodes, weights = np.polynomial.legendre.leggauss(64)
        cosine = (0.5 * (nodes + 1)) ** 2
        wi = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=-1)
        assert abs(2 * weights @ (lost(wi) * cosine * np.sqrt(cosine)) - mean) < 0.002


def test_surfaces_without_an_index_or_width_lose_nothing():
    assert not surface_loss(Widths(0.5, 0.5), 1.0)[0](WI).any()
    assert surface_loss(Widths(0.01, 0.01), 1.5)[0](WI[1:]).max() < 0.02


def test_codes_have_the_lobe():
    """The E of a code of one coat is about 1 %."""
    stack = urushi.coat(urushi.diffuse(0.8), 0.6, ior=1.5, energy_compensation=True)
    f, _ = urushi.simulate(stack, WI, WI[::-1] * [-1, 1, 1], walks=1 << 14)
    found = urushi.encode(stack).f(WI, WI[::-1] * [-1, 1, 1])
    np.testing.assert_allclose(found, f, rtol=0.05)


def test_slabs_are_refused():
    with pytest.raises(ParameterError, match="energy_compensation needs an opaque bottom"):
        urushi.coat(urushi.slab(0.3), energy_compensation=True)


@pytest.mark.parametrize("fast", (False, True))
def test_layers_have_the_lobe_of_the_walk_and_files_hold_it(fast, tmp_path):
    """Within 1 % by transport and 5 % by the layering network, and five standard errors."""
    gold = urushi.conductor(0.3, (0.9, 0.7, 0.3))
    options = {"color": (0.9, 0.6, 0.3), "energy_compensation": True}
    wi, wo = WI, np.flip(WI, 0) * [-1, 1, 1]
    f, error = urushi.simulate(urushi.coat(gold, 0.8, ior=1.5, **options), wi, wo, walks=1 << 14)
    coated = urushi.layer(urushi.dielectric(0.8, ior=1.5), gold, fast=fast, **options)
    assert (np.abs(coated.f(wi, wo) / f - 1) < (0.05 if fast else 0.01) + 5 * error / f).all()
    coated.save(tmp_path / "coated.safetensors")
    loaded = urushi.load(tmp_path / "coated.safetensors")
    assert (loaded.f(wi, wo) == coated.f(wi, wo)).all()
    top = urushi.dielectric(0.1, ior=1.5)
    assert np.allclose(urushi.layer(top, loaded).f(wi, wo), urushi.layer(top, coated).f(wi, wo))


def test_layers_of_two_widths_refuse_the_lobe():
    top = urushi.dielectric(alpha_u=0.3, alpha_v=0.1, ior=1.5)
    with pytest.raises(ParameterError, match=r"give it to urushi\.coat"):
        urushi.layer(top, urushi.diffuse(0.5), energy_compensation=True)
