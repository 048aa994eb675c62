"""Materials with an analytic lobe: known lobes are exact, and blends of them are smooth."""

import functools
import itertools

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.material.conftest import error

from urushi.material import Material, encode, energy, lerp
from urushi.material.energy import code_albedos
from urushi.walk import analytic, coat, conductor, dielectric, diffuse

BARE = (
    conductor(0.03, (0.95, 0.6, 0.3)),
    conductor(0.4, eta=(0.2, 0.9, 1.2), k=(3.9, 2.5, 2.2)),
    dielectric(0.1, 1.5),
    dielectric(0.2, 0.7),
)


#: Directions above the horizon, not at it.
PAIRS = pairs_above(1000, 1, 0.03)


@pytest.mark.parametrize("surface", BARE)
def test_bare_interfaces_are_exact(surface, model):
    """The tolerance is the rounding of single precision in sharp lobes."""
    material = encode(surface, model)
    expected = analytic.f(surface, *PAIRS)
    np.testing.assert_allclose(material.f(*PAIRS), expected, rtol=2e-3, atol=1e-6)


def test_the_topmost_interface_of_a_stack_is_the_lobe(model):
    stack = coat(conductor(0.3, 0.5), alpha=(0.1, 0.2, 0.3), eta=1.7, sigma_t=1.0)
    found = encode(stack, model).latents[:, :6]
    np.testing.assert_allclose(found[:, 0], (0.1, 0.2, 0.3), rtol=1e-6)
    np.testing.assert_allclose(found[:, 3:], [[1, 1.7, 0]] * 3, rtol=1e-6)


def test_a_lobe_that_reflects_everything_does_not_black_out_the_rest(model):
    z = encode(conductor(0.01, 1.0), model).latents.copy()
    z[:, 6] = -3.0
    limited = energy.limit_albedo(model, z)
    rest = energy.rest_albedos(model, limited).max(axis=1)
    assert (rest > 0.5 * energy.LEAST_REST).all()
    assert code_albedos(model, limited).max() < 1 + 2 * energy.LEAST_REST


@functools.cache
def materials(model) -> list[Material]:
    """Metal, glass, diffuse, a sharp conductor with a rest, nothing, and a table."""

    def both(wi, wo):
        return 0.1 + analytic.f(BARE[1], wi, wo)

    return [
        encode(conductor(0.05, eta=0.2, k=3.9), model),
        encode(BARE[2], model),
        encode(diffuse((0.5, 0.2, 0.1)), model),
        encode(both, model, table=False),
        encode(diffuse(0.0), model),
        encode(both, model, table=True),
    ]


@pytest.mark.parametrize(("first", "second"), [*itertools.combinations(range(6), 2)])
def test_blends_are_linear_in_f(trained, first, second):
    """Within the error of a table."""
    a, b = materials(trained)[first], materials(trained)[second]
    for share in (0.0, 0.3, 1.0):
        expected = (1 - share) * a.f(*PAIRS) + share * b.f(*PAIRS)
        assert error(lerp(a, b, share), expected, *PAIRS).max() < 0.01
