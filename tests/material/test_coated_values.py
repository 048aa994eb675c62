"""f of coats of one GGX width and two at pairs: walks, closed forms, reciprocity, channels."""

import math

import numpy as np
import pytest

import urushi
from urushi.checks import CoatParameters, Widths
from urushi.core import direction_sets, fresnel
from urushi.core.error_metrics import stack_error
from urushi.core.microfacet import of_widths
from urushi.core.namespace import NUMPY
from urushi.core.quadrature import directional_albedos
from urushi.core.table import MIN_LOG, SHAPE, node_pairs
from urushi.material import adding
from urushi.material.coated_values import coated_f
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.walk import conductor, diffuse
from urushi.walk.simulate import albedo

#: Coats: alpha, eta, albedo, sigma_t and g.
COATS = {
    "smooth": (0.02, 1.5, 0.0, 0.0, 0.0),
    "tinted": (0.2, 1.4, 0.0, 0.6, 0.0),
    "scattering": (0.05, 1.6, 0.9, 1.0, 0.5),
    "less dense": (0.1, 0.7, 0.0, 0.0, 0.0),
    "no interface": (0.1, 1.0, 0.5, 0.7, 0.3),
}


def one(alpha, *others) -> CoatParameters:
    return CoatParameters(of_widths(np.float64, alpha), *map(np.float64, others))


def metal(alpha, r0=0.8):
    """Numbers of a metal's lobe."""
    return np.float32([[alpha, r0, 1, 0, 1.5, 0]])


def bare(lobe) -> Substrate:
    return substrate(np.full((*SHAPE, len(lobe)), MIN_LOG), lobe)


def lambertian(albedo, *stretch2) -> Substrate:
    return substrate(np.full((*SHAPE, 1), math.log(albedo / math.pi)), None, *stretch2)


def substrate(*parts) -> Substrate:
    return Substrate.of(Reflector.of_logs(*parts))


def brushed() -> Substrate:
    """A metal of the widths 0.1 and 0.4."""
    lobe = np.float32([[0.1, 0.9, 1.0, 0.0, 1.5, 0.0, 0.4]])
    return substrate(np.full((*SHAPE, 1), MIN_LOG), lobe, np.ones(1))


def pairs(count, seed=0):
    return direction_sets.cosine_pairs(np.random.default_rng(seed), count)


@pytest.mark.parametrize(
    ("below", "values"),
    [(metal, values) for metal in ("sharp", "wide") for values in COATS.values()]
    + [("brushed", (Widths(0.1, 0.3), 1.5, 0.5, 0.5, 0.0))],
)
def test_reciprocal_and_symmetric_about_both_planes(below, values):
    """Directions of a pair have different points, which find the lobe with some per cent."""
    below = brushed() if below == "brushed" else bare(metal(0.03 if below == "sharp" else 0.4))
    wi, wo = pairs(200)
    f = coated_f(below, one(*values), wi, wo)[:, 0]
    images = [(wi * sign, wo * sign) for sign in np.float32([[1, -1, 1], [-1, 1, 1]])]
    for sides in [(wo, wi), *images]:
        found = coated_f(below, one(*values), *sides)[:, 0]
        assert stack_error(found, f, wi[:, 2], wo[:, 2]) < 0.02


def test_a_coat_is_the_same_among_others_of_two_widths():
    alpha, values = np.array([0.2, 0.2, 0.3]), ([1.5] * 3, [0, 0.5, 0], [0, 1, 0.5], [0] * 3)
    coats = CoatParameters(alpha, *np.array(values))
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(2), 50, lowest_cosine=0.1)
    together = coated_f(brushed(), coats, wi, wo)
    for channel in range(3):
        alone = coated_f(brushed(), CoatParameters(*(p[channel] for p in coats)), wi, wo)
        np.testing.assert_allclose(together[:, channel], alone[:, 0], rtol=1e-5)


@pytest.mark.parametrize(
    ("albedo", "sigma_t"),
    [
        ([0.8] * 5, np.linspace(0, 2, 5)),
        ([0.02, 0.0, 0.0, 0.0], [0.18, 0.23, 0.18, 0.13]),
        ([0.0, 0.0, 0.6, 0.6], [80.0, 1.0, 1.0, 80.0]),  # the first is black
        ([0.0] * 4, [80.0, 90.0, 100.0, 110.0]),
    ],
)
def test_many_coats_over_one_bottom(albedo, sigma_t):
    """Coats of any shape; more than three media below one interface are sums of a few."""
    wi, wo = pairs(50)
    columns, below = [np.reshape(x, (-1, 1)) for x in (albedo, sigma_t)], lambertian(0.5)
    f = coated_f(below, CoatParameters(np.full_like(columns[1], 0.1), 1.5, *columns, 0.0), wi, wo)
    assert f.shape == (50, len(albedo), 1)
    for row, medium in enumerate(zip(albedo, sigma_t, strict=True)):
        alone = coated_f(below, one(0.1, 1.5, *medium, 0.0), wi, wo)
        np.testing.assert_allclose(f[:, row], alone, rtol=0.01, atol=1e-25)  # black


def test_a_smooth_coat_over_black_velvet_dims_it_twice():
    """The bottom reflects hardly any light again: f = T T f' exp(-sigma_t / c' ...) / eta^2."""

    def faint(wi, wo):
        return 1e-4 * (1 + 3 * wi[:, 2] * wo[:, 2])

    eta, sigma_t, expected, inside = 1.5, 0.4, 1.0, []
    below = substrate(np.log(faint(*node_pairs())).reshape(*SHAPE, 1))
    sides = direction_sets.cosine_pairs(np.random.default_rng(4), 500, lowest_cosine=0.3)
    for w in sides:
        z = np.sqrt(1 - (1 - w[:, 2] ** 2) / eta**2)
        inside.append(np.column_stack([w[:, :2] / eta, z]))
        expected *= (1 - fresnel.dielectric(w[:, 2], eta, NUMPY)[0]) * np.exp(-sigma_t / z)
    expected *= faint(*inside) / eta**2
    ratio = coated_f(below, one(0.01, eta, 0.0, sigma_t, 0.0), *sides)[:, 0] / expected
    np.testing.assert_allclose(ratio, 1, atol=0.01)


def test_without_interface_and_medium_the_bottom_remains():
    wi, wo = pairs(100)
    f = coated_f(bare(metal(0.1)), one(0.1, 1.0, 0.0, 0.0, 0.0), wi, wo)[:, 0]
    np.testing.assert_allclose(f, lobes.f(metal(0.1), wi, wo), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize(
    ("alpha", "least", "most"),
    [(0.02, 0.995, 1.003), (0.3, 0, 1.003), (Widths(0.02, 0.05), 0.985, 1.015)],
)
def test_white_below_a_clear_coat_reflects_what_enters(alpha, least, most):
    """With the interface's reflection, all light that falls on a smooth clear coat.

    Rough interfaces lose what their facets reflect or transmit more than once.
    """
    two, wi = isinstance(alpha, Widths), np.array([[0, 0, 1.0], [0.6, 0, 0.8], [0.8, 0, 0.6]])
    clear, white = one(alpha, 1.5, 0.0, 0.0, 0.0), lambertian(1.0, *[np.ones(1)] * two)
    lobe = lobes.of_coat(clear.alpha, clear.eta)

    def f(wi, wo):
        return coated_f(white, clear, wi, wo) + lobes.f(lobe, wi, wo)[:, None]

    albedo = directional_albedos(f, wi, anisotropic=two, azimuths=4 if two else 16)
    assert least < albedo.min() and albedo.max() < most


def test_light_that_a_clear_coat_traps_over_a_sharp_metal_is_that_of_the_walk():
    wi = np.array([[0.8, 0.0, 0.6]])
    gold = conductor(0.104, 0.991)
    stack = urushi.coat(gold, alpha=0.021, ior=1.95)
    expected, se = albedo(stack, wi, walks=1 << 17)
    found = urushi.layer(urushi.dielectric(0.021, 1.95), urushi.encode(gold))
    # A grid without nodes beside the angle of total reflection gives 0.01 more.
    error = found.directional_albedo(wi)[0, 0] - expected[0, 0]
    assert abs(error) < 0.004 + 2 * se[0, 0]


@pytest.mark.parametrize("g", [-0.9, -0.7])
def test_light_that_a_medium_sends_back_is_that_of_the_walk(g):
    stack = urushi.coat(diffuse(0.3), alpha=0.05, ior=1.5, albedo=0.95, sigma_t=2, g=g)
    angles = np.linspace(0.3, 1.2, 6)  # between the elevations of the grid, beside the top's lobe
    w = np.stack([np.sin(angles), 0 * angles, np.cos(angles)], axis=1).astype(np.float32)
    expected, se = urushi.simulate(stack, w, w, walks=1 << 15)
    own = one(0.05, 1.5, 0.95, 2.0, g)
    found = coated_f(urushi.encode(diffuse(0.3)), own, w, w)[:, :1]
    # The grid itself is 3 and 20 % off here.
    assert (abs(found / expected - 1) < 0.02 + 3 * se / expected).all()


def test_modes_of_a_substrate_are_those_of_its_brdf():
    below = substrate(np.full((*SHAPE, 1), math.log(0.1)), metal(0.2))
    direct = adding.bottom_modes(lambda wi, wo: 0.1 + lobes.f(metal(0.2), wi, wo)[:, None])
    found = below.on_grid(np.arange(1), ()).modes
    np.testing.assert_allclose(found, direct, atol=2e-3)
    assert bare(metal(0.2)).width[0] == pytest.approx(0.2, rel=0.1)
    assert np.isinf(lambertian(0.5).width).all()
