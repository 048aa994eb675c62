"""Doubling inside a coat against another grid; whole coats are compared with the walk."""

import numpy as np
import pytest
from tests.oracles import doubling
from tests.oracles.doubling import CosineGrid

from urushi.material import adding

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
