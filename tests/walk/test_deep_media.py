"""Deep lossless media: the walk's diffuser in their middle against adding and doubling."""

import numpy as np
import pytest
from tests.directions import pairs_above
from tests.oracles import adding_doubling
from tests.oracles.adding_doubling import layers
from tests.oracles.adding_doubling.quadrature import CosineGrid

from urushi.errors import ParameterError
from urushi.walk import coat, conductor, diffuse, medium, simulate
from urushi.walk.monte_carlo import backend

GRID = CosineGrid.gauss(nodes=24, modes=1)
IDENTITY = np.eye(24)
#: A perfect diffuser in the solver's weighted form.
DIFFUSER = np.outer(GRID.root, GRID.root) / (GRID.root @ GRID.root)


def under(reflect, transmit, bottom):
    """The reflection of a layer over a bottom, all bounces included."""
    return reflect + transmit @ bottom @ np.linalg.solve(IDENTITY - reflect @ bottom, transmit)


def slab(sigma_t, g):
    """Reflection and transmission of a lossless medium, averaged over azimuth."""
    return (modes[0] for modes in layers.slab(GRID, 1.0, sigma_t, g))


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("depth", [12.5, 20.0, 60.0])
@pytest.mark.parametrize("bottom", [0 * IDENTITY, 0.95 * DIFFUSER, 0.9 * IDENTITY])
def test_a_diffuser_replaces_the_middle_of_a_deep_medium(g, depth, bottom):
    """Within 0.1 % at all pairs of angles, and 0.03 % of the albedo (mirrors, diffusers, nothing).

    The error decays with the depth on either side of the sheet, which depends on g only.
    """
    depth = depth / (1 - max(g, 0))
    number = backend().Float
    short = medium.of(number(1), number(depth), number(g))
    assert short.deep[0]
    kept, passed = float(short.sigma_t[0]), float(short.passed[0])
    expected = under(*slab(depth, g), bottom)
    half = list(slab(kept / 2, g))
    found = under((1 - passed) * DIFFUSER, passed * DIFFUSER, under(*half, bottom))
    found = under(*half, found)
    np.testing.assert_allclose(found, expected, rtol=1e-3)
    np.testing.assert_allclose(found @ GRID.root, expected @ GRID.root, rtol=3e-4)


def test_only_deep_lossless_media_have_a_diffuser():
    number, color = backend().Float, backend().Array3f
    for albedo, depth, g in ((0.999, 100, 0), (1, 11, 0), (1, 100, 0.9)):
        assert not medium.of(number(albedo), number(depth), number(g)).deep[0]
    assert medium.of(color(1), color(20, 50, 1e4), color(0)).deep[0]
    assert not medium.of(color(1), color(5, 50, 1e4), color(0)).deep[0]
    assert not medium.of(color(1, 0.9, 1), color(20, 50, 1e4), color(0)).deep[0]


@pytest.mark.parametrize(
    ("bottom", "sigma_t", "g"),
    [(diffuse(0.1), 14.0, 0.0), (conductor(0.3, 0.9), 50.0, 0.5), (diffuse(0.5), 1e4, 0.0)],
)
def test_walks_through_deep_media_end_at_the_right_value(bottom, sigma_t, g):
    """The solver's own error at 1e4 is 0.1 %."""
    wi, wo = pairs_above(8, 1, 0.3)
    stack = coat(bottom, 0.3, 1.5, albedo=1, sigma_t=sigma_t, g=g)
    f, se = (x[:, 0] for x in simulate(stack, wi, wo, walks=1 << 11, seed=1, progress=False))
    expected = adding_doubling.solve(stack, wi, wo, nodes=20, modes=20)[:, 0]
    z = (f - expected) / np.hypot(se, 0.002 * expected)
    assert (z**2).mean() < 1 + 4 * np.sqrt(2 / len(z))
    assert abs(f.sum() / expected.sum() - 1) < 4 * np.sqrt((se**2).sum()) / expected.sum() + 0.002


def test_the_deepest_medium_is_bounded():
    coat(diffuse(0.5), sigma_t=1e6)
    with pytest.raises(
        ParameterError, match=r"sigma_t is 1e\+300; .* an optical depth in \[0, 1e6"
    ):
        coat(diffuse(0.5), sigma_t=1e300)
