"""The operators of Weier and Belcour 2020 against the isotropic ones, closed forms and the walk."""

import numpy as np
import pytest
from benchmarks import measures
from research.rivals import belcour, weier

from urushi.core.direction_sets import cosine_pairs
from urushi.walk import coat, conductor, dielectric, diffuse, simulate

BOTTOMS = {
    "schlick": conductor(0.2, r0=0.9),
    "complex": conductor(0.4, eta=0.2, k=3.9),
    "dielectric": dielectric(0.3, 1.7),
    "diffuse": diffuse(0.5),
}


@pytest.mark.parametrize("eta", [0.7, 1.3])
@pytest.mark.parametrize("name", BOTTOMS)
def test_equal_widths_are_the_isotropic_model(name: str, eta: float) -> None:
    # The same operations on both axes: only the root of a square rounds otherwise.
    wi, wo = cosine_pairs(np.random.default_rng(0), 500)
    stack = coat(coat(BOTTOMS[name], 0.3, eta, 0.5, 0.4, 0.3), 0.05, 1.5, 0.9, 0.7, 0.8)
    np.testing.assert_allclose(weier.f(stack, wi, wo), belcour.f(stack, wi, wo), rtol=1e-5)


def test_exchanged_widths_are_a_quarter_turn() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(4), 500)
    stack = coat(conductor(alpha_u=0.1, alpha_v=0.4, r0=0.8), alpha_u=0.4, alpha_v=0.05, eta=1.4)
    turned = coat(conductor(alpha_u=0.4, alpha_v=0.1, r0=0.8), alpha_u=0.05, alpha_v=0.4, eta=1.4)
    np.testing.assert_allclose(
        weier.f(turned, wi[:, [1, 0, 2]], wo[:, [1, 0, 2]]), weier.f(stack, wi, wo), rtol=1e-4
    )


def test_lacquered_hairlines_are_near_the_walk() -> None:
    # A smooth, clear coat: E is 22 %, and 16 % for a metal of the width 0.3 alone, which is the
    # isotropic model. The geometric mean of the widths in place of both gives 64 %.
    wi, wo = cosine_pairs(np.random.default_rng(6), 200)
    hairlines = coat(conductor(alpha_u=0.06, alpha_v=0.3, r0=0.9), 0.05, 1.5)
    walked = simulate(hairlines, wi, wo, walks=4096, seed=1)[0][:, 0]

    def error(f) -> float:
        return float(measures.stack_error(f[:, 0], walked, wi[:, 2], wo[:, 2]))

    isotropic = coat(conductor(float(np.sqrt(0.06 * 0.3)), r0=0.9), 0.05, 1.5)
    found = error(weier.f(hairlines, wi, wo))
    assert found < 0.25
    assert error(belcour.f(isotropic, wi, wo)) > 2 * found
