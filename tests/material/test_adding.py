"""Doubling inside a coat against another grid; whole coats are compared with the walk."""

import numpy as np
import pytest
from tests.oracles import doubling
from tests.oracles.doubling import CosineGrid

import urushi
from urushi.checks import Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.core.error_metrics import energy_weight
from urushi.core.namespace import NUMPY, Components
from urushi.core.table import linear_at
from urushi.material import adding, adding_quadrant
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate

#: Thin to thick media, of albedos down to a half, that scatter backwards, evenly and forwards.
MEDIA = [
    (1.0, 0.05, 0.9),
    (0.5, 0.5, 0.5),
    (0.9, 0.5, -0.9),
    (0.9, 2.0, -0.5),
    (0.9, 2.0, 0.9),
    (1.0, 10.0, -0.9),
    (0.99, 20.0, 0.0),
    (0.99, 20.0, 0.9),
]


@pytest.mark.parametrize(("albedo", "sigma_t", "g"), MEDIA)
def test_media_are_those_of_the_solver_on_another_grid(albedo, sigma_t, g):
    """Reflection and transmission, values and light for each direction from which it comes.

    The solver shares no code: nodes are those of Gauss in the cosine, the phase function is a
    Legendre series, and doubling begins at 2e-8. The tolerance has two parts, both of `adding`'s
    grid. Its first layer scatters once only. That leaves out a share of the light like the layer's
    depth, and changes the attenuation of a thick medium by as much for each unit of its depth. And
    the grid integrates a phase function up to the degree that is its number of azimuths; Legendre's
    moments above are powers of g from there on, a few of which add up.
    """
    own = adding.grid()
    tolerance = adding.FIRST_DEPTH * (2 + sigma_t / 2) + 4 * abs(g) ** (2 * own.azimuths.size - 2)
    ends = np.r_[0.5, np.ones(len(own.azimuths) - 2), 0.5]  # of the trapezium rule
    share = np.multiply.outer(np.outer(own.weights, own.weights), ends)
    grid = CosineGrid.gauss(nodes=64, modes=64)
    reflected, passed = doubling.slab(grid, albedo, sigma_t, g)
    passed = passed - np.diag(doubling.direct(grid, sigma_t))
    basis = grid.interpolation(own.cosines) / grid.root  # weights of both sides are taken out
    m = np.arange(len(reflected))
    series = np.where(m == 0, 1, 2)[:, None] * np.cos(m[:, None] * own.azimuths)
    # Directions of propagation there; here both point away from what reflects.
    solved = (reflected * (-1.0) ** m[:, None, None], passed)
    for modes, operator in zip(adding.medium(albedo, sigma_t, g), solved, strict=True):
        found = own.values_of_modes(modes)
        expected = np.einsum("mij,mh->ijh", basis @ operator @ basis.T, series)
        assert (np.abs(found - expected) * share).sum() < tolerance * (expected * share).sum()
        light, expected_light = (x[0] @ own.weights for x in (modes, own.modes(expected)))
        np.testing.assert_allclose(light, expected_light, rtol=0, atol=tolerance)


PAIRS = cosine_pairs(np.random.default_rng(0), 2000, lowest_cosine=0.02)


def in_table(values, pairs):
    """Values (N,) of `adding_quadrant.table` at pairs."""
    places = adding_quadrant.coordinates(*(Components(*w.T) for w in pairs), NUMPY)
    return linear_at(adding_quadrant.table(values)[..., None], *places)[:, 0]


def test_the_table_of_two_widths_holds_symmetric_functions():
    """Linear interpolation between azimuths of 11 degrees is off by less than 0.005."""

    def f(wi, wo):
        return 1 + 0.4 * wi[:, 0] * wo[:, 0] - 0.3 * wi[:, 1] * wo[:, 1] + 0.2 * wi[:, 2] * wo[:, 2]

    w = adding_quadrant.directions()
    first, second = w.repeat(len(w), axis=0), np.tile(w, (len(w), 1))
    images = [f(first, second * (*sign, 1)) for sign in adding_quadrant.SIGNS]
    found = in_table(np.float32(images).reshape(4, len(w), len(w)), PAIRS)
    np.testing.assert_allclose(found, f(*PAIRS), rtol=0, atol=0.005)


@pytest.mark.parametrize("medium", [(0.0, 0.0, 0.0), (0.9, 1.0, 0.5)])
def test_round_surfaces_are_the_same_by_both_grids(medium):
    """Fourier modes, and parts of a quadrant, of rough metal under a rough interface.

    Their azimuths differ, and the peak of the metal is 3 of them wide; E is below 0.01.
    """
    metal = Substrate.of(Reflector.of(urushi.encode(urushi.conductor(0.4, r0=0.8))))
    back = adding.interface_modes(0.3, 1.5)
    modes, own = adding.bottom_modes(metal.reflector.f)[0], adding.grid()
    round_values, _ = adding.seen_inside(modes, back, [medium])
    expected = own.interpolated(round_values[..., None], *PAIRS)[:, 0]
    values = adding_quadrant.seen_inside(
        adding_quadrant.bottom_parts(metal.reflector.f)[0],
        adding_quadrant.interface_parts(Widths(0.3, 0.3), 1.5),
        medium,
    )
    weight = energy_weight(*(w[:, 2] for w in PAIRS))
    difference = np.abs(in_table(values, PAIRS) - expected)
    assert (difference * weight).sum() < 0.01 * (expected * weight).sum()
