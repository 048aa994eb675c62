"""Surfaces without coats: closed forms, energy and reciprocity."""

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.oracles.adding_doubling import surfaces

from urushi.walk import conductor, dielectric, diffuse
from urushi.walk.analytic import f

DESCRIPTIONS = {
    "schlick": conductor((0.1, 0.3, 1.0), 0.5),
    "complex": conductor(0.3, eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9)),
    "dielectric": dielectric(0.2, (1.1, 1.5, 3.0)),
    "diffuse": diffuse((0.1, 0.5, 1.0)),
}


@pytest.mark.parametrize("alpha", [0.05, 0.5, 1.0])
def test_conductors_follow_the_closed_form(alpha: float) -> None:
    wi, wo = pairs_above(500, 0, 0.05)
    for description, kernel in (
        (conductor(alpha, 0.3), surfaces.conductor_schlick(alpha, 0.3)),
        (conductor(alpha, eta=0.9, k=2.4), surfaces.conductor_complex(alpha, 0.9, 2.4)),
    ):
        expected = surfaces.at_pairs(kernel, wi, wo)
        np.testing.assert_allclose(f(description, wi, wo)[:, 0], expected, rtol=3e-4)


def test_diffuse_is_constant() -> None:
    value = f(diffuse((0.1, 0.5, 1.0)), *pairs_above(10, 4))
    np.testing.assert_allclose(value, np.broadcast_to([0.1, 0.5, 1.0], (10, 3)) / np.pi, rtol=1e-6)


@pytest.mark.parametrize("description", DESCRIPTIONS.values(), ids=DESCRIPTIONS.keys())
def test_surfaces_are_reciprocal_and_dark_below_the_horizon(description) -> None:
    wi, wo = pairs_above(500, 6, 0.05)
    there, back = f(description, wi, wo), f(description, wo, wi)
    assert there.dtype == np.float32
    assert there.shape == (500, 3)
    assert np.all(there >= 0)
    np.testing.assert_allclose(there, back, rtol=1e-5)
    down = wo * [1, 1, -1]
    assert not f(description, wi, down).any()
    assert not f(description, down, wi).any()
    assert not f(description, down, down).any()
