"""The walk against an adding-doubling solver, and the diffuser in deep media that lose no light."""

import numpy as np
import pytest
from tests.directions import DOWN, at_cosines, pairs_above
from tests.oracles import adding_doubling
from tests.oracles.adding_doubling import layers
from tests.oracles.adding_doubling.quadrature import CosineGrid, series

from urushi.walk import coat, conductor, dielectric, diffuse, medium, simulate, slab
from urushi.walk.monte_carlo import backend

GRID = CosineGrid.gauss(nodes=24, modes=1)
IDENTITY = np.eye(24)
#: A perfect diffuser in the solver's weighted form.
DIFFUSER = np.outer(GRID.root, GRID.root) / (GRID.root @ GRID.root)

#: Stacks, nodes and modes of the solver, walks, and pairs above a cosine.
STACKS = {
    "two coats": coat(
        coat(conductor(0.3, 0.8), 0.4, 1.3, 0.9, (2.0, 0.5, 0.0), g=0.5),
        *(0.25, 1.4, (0.95, 0.8, 1.0), (0.5, 3.0, 1.0)),
        g=-0.5,
    ),
    # A medium of a lower index than the coat above it.
    "thinner medium": coat(
        coat(diffuse(0.8), 0.3, 0.8, 0.95, (1.0, 0.3, 8.0), g=(0.9, -0.8, 0.0)), 0.25, 1.5, 0.9, 0.5
    ),
    "complex index": coat(conductor(0.4, eta=0.2, k=3.0), 0.3, 1.4, 0.5, 0.5),
    "dielectric": coat(dielectric(0.4, 1.7), 0.3, 1.4, 0.5, 0.5),
    "deep": coat(diffuse(0.1), 0.3, 1.5, 1, 14.0),
    "deep on metal": coat(conductor(0.3, 0.9), 0.3, 1.5, 1, 50.0, 0.5),
    "deepest": coat(diffuse(0.5), 0.3, 1.5, 1, 1e4),
}


@pytest.mark.parametrize("name", STACKS)
def test_walks_agree_with_the_solver(name: str) -> None:
    """The solver's own error is 0.1 % in the median, and 0.2 % is allowed."""
    deep = name.startswith("deep")
    wi, wo = pairs_above(8, 1, 0.3) if deep else pairs_above(120, 7, 0.05)
    f, walks = adding_doubling.solve(STACKS[name], wi, wo), 1 << 11 if deep else 8_000
    walked, se = simulate(STACKS[name], wi, wo, walks=walks, seed=9, progress=False)
    z = (walked - f) / np.hypot(se, 0.002 * f)
    assert np.all(np.mean(z**2, axis=0) < (1 + 4 * np.sqrt(2 / 8) if deep else 1.4))
    allowed = 4 * np.sqrt((se**2).sum(axis=0)) / f.sum(axis=0) + 0.002
    assert np.all(np.abs(walked.sum(axis=0) / f.sum(axis=0) - 1) < allowed)


@pytest.mark.parametrize("g", [0.0, 0.5])
def test_a_scattering_medium_of_index_one_is_the_solvers_slab(g: float) -> None:
    """Its reflection over black, and its transmission without a bottom. The solver has 0.01 %."""
    grid = CosineGrid.gauss(nodes=16, modes=48)
    first, second = (x.ravel() for x in np.indices((16, 16))[:, 4::4, 5::4])  # no straight light
    phi = np.linspace(0, np.pi, len(first))
    # The solver's azimuth is that between directions of propagation.
    wi, wo = at_cosines(grid.mu[first]), at_cosines(grid.mu[second], np.pi - phi)
    coefficients = (0.3, 1, 0.9, 2.0, g)
    stacks = coat(diffuse(0), *coefficients), slab(*coefficients)
    for modes, stack, side in zip(
        layers.slab(grid, *coefficients[2:]), stacks, (1, DOWN), strict=True
    ):
        expected = series(modes[:, first, second], phi) / (grid.root[first] * grid.root[second])
        f, se = simulate(stack, wi, wo * side, walks=1 << 14, seed=3)
        error = np.abs(f[:, 0] - expected)
        np.testing.assert_array_less(error, 4.5 * se[:, 0] + 1e-3 * expected)


def under(reflect, transmit, bottom):
    """The reflection of a layer over a bottom, all bounces included."""
    return reflect + transmit @ bottom @ np.linalg.solve(IDENTITY - reflect @ bottom, transmit)


@pytest.mark.parametrize("g", [-0.5, 0.0, 0.5, 0.9])
@pytest.mark.parametrize("depth", [12.5, 20.0, 60.0])
def test_a_diffuser_replaces_the_middle_of_a_deep_medium(g: float, depth: float) -> None:
    """Within 0.1 % at all pairs of angles, and 0.03 % of the albedo (mirrors, diffusers, nothing).

    The error decays with the depth on either side of the sheet, which depends on g only.
    """

    def averaged(sigma_t):
        """Reflection and transmission of a lossless medium, averaged over azimuth."""
        return [modes[0] for modes in layers.slab(GRID, 1.0, sigma_t, g)]

    depth, number = depth / (1 - max(g, 0)), backend().Float
    short = medium.of(number(1), number(depth), number(g))
    assert short.deep[0]
    whole, half = averaged(depth), averaged(float(short.sigma_t[0]) / 2)
    passed = float(short.passed[0])
    for bottom in (0 * IDENTITY, 0.95 * DIFFUSER, 0.9 * IDENTITY):
        expected = under(*whole, bottom)
        found = under((1 - passed) * DIFFUSER, passed * DIFFUSER, under(*half, bottom))
        found = under(*half, found)
        np.testing.assert_allclose(found, expected, rtol=1e-3)
        np.testing.assert_allclose(found @ GRID.root, expected @ GRID.root, rtol=3e-4)


def test_only_deep_media_that_lose_no_light_have_a_diffuser() -> None:
    number, color = backend().Float, backend().Array3f
    for albedo, depth, g in ((0.999, 100, 0), (1, 11, 0), (1, 100, 0.9)):
        assert not medium.of(number(albedo), number(depth), number(g)).deep[0]
    for albedo, least, deep in ((1, 20, True), (1, 5, False), ((1, 0.9, 1), 20, False)):
        albedo = color(*albedo) if isinstance(albedo, tuple) else color(albedo)
        assert medium.of(albedo, color(least, 50, 1e4), color(0)).deep[0] == deep
