"""Media: the phase function, doubled slabs, and the diffuser in deep media that lose no light."""

import drjit as dr
import numpy as np
import pytest
from tests.directions import DOWN, at_cosines
from tests.oracles import doubling
from tests.oracles.doubling import CosineGrid, series

from urushi.core.random import stream
from urushi.walk import coat, diffuse, medium, simulate, slab, walk
from urushi.walk.bottoms import KINDS
from urushi.walk.monte_carlo import backend

ASYMMETRIES = [-0.95, -0.5, -1e-3, -1e-6, 0.0, 1e-8, 9.9e-4, 1.01e-3, 0.3, 0.8, 0.97]


def cumulative(g: float, cos: np.ndarray) -> np.ndarray:
    """The exact distribution function of the cosine, in float64."""
    cos = cos.astype(np.float64)
    if abs(g) < 1e-5:  # the closed form is 0 / 0; first order in g
        return (1 + cos) / 2 - 0.75 * g * (1 - cos**2)
    # (1 - g^2) / 2g (1/s - 1/(1+g)) without cancelling at small g
    s = np.sqrt(1 + g * g - 2 * g * cos)
    return (1 - g * g) * (1 + cos) / (s * (1 + g) * (1 + g + s))


@pytest.mark.parametrize("g", ASYMMETRIES)
def test_the_phase_function_is_normalised_of_mean_cosine_g_and_sampled_by_inversion(
    jit, g: float
) -> None:
    nodes, weights = np.polynomial.legendre.leggauss(200)
    values = medium.hg(jit.Float(nodes.astype(np.float32)), jit.Float(g)).numpy()
    # float32 cosines and a peak that is sharp for the largest |g|
    assert 2 * np.pi * np.sum(values * weights) == pytest.approx(1, abs=1e-4)
    assert 2 * np.pi * np.sum(values * weights * nodes) == pytest.approx(g, abs=1e-4)
    u = np.concatenate([[0, 2**-24, 1 - 2**-24], np.linspace(0, 1, 1001)[:-1]]).astype(np.float32)
    cos = medium.sample_hg(jit.Array3f(0, 0, 1), jit.Float(g), jit.Float(u), 0.3).z.numpy()
    # At |g| = 0.97 the density of cosines reaches 1100, and float32 cosines are 6e-8 apart.
    np.testing.assert_allclose(cumulative(g, cos), u, atol=1.5e-4)


@pytest.mark.parametrize("g", [0.9999, -0.9999, 1 - 2**-24, 2**-24 - 1])
def test_the_sharpest_peak_is_finite_and_positive(jit, g: float) -> None:
    cosines = np.float32([-1 - 1e-6, -1, -1 + 1e-7, 0, 1 - 1e-7, 1, 1 + 1e-6])  # of rounded vectors
    values = medium.hg(jit.Float(cosines), jit.Float(g)).numpy()
    assert np.isfinite(values).all() and (values > 0).all()


@pytest.mark.parametrize("g", [0.9999, 1 - 1e-12])
def test_a_medium_that_does_not_deflect_light_changes_nothing(g: float) -> None:
    # Also where single precision rounds g to 1
    directions = at_cosines([1.0, 0.5]), at_cosines([0.8, 0.4], 2.0)
    clear, cloudy = (
        simulate(coat(diffuse(0.5), 0.3, 1.3, 1.0, sigma_t, g), *directions, walks=1 << 15)
        for sigma_t in (0.0, 2.0)
    )
    np.testing.assert_array_less(np.abs(cloudy[0] - clear[0]), 5 * np.hypot(clear[1], cloudy[1]))


class ForwardCoat:
    """A coat of colours whose lossless medium hardly deflects light, as the walk's layers."""

    count = 1

    def __init__(self, jit, sigma_t: float, g: tuple[float, float, float]) -> None:
        self._interface = jit.Float(0.3), jit.Float(1.3)
        color = jit.Array3f
        self._medium = color(1), color(sigma_t), color(g)

    def interface(self, index):
        return self._interface

    def medium(self, index):
        return self._medium


@pytest.mark.parametrize("g", [(0.99999, 0.99999, 0.99999), (0.999999, 0.9999, 0.99998)])
def test_media_that_do_not_deflect_light_change_no_colour(jit, g) -> None:
    walks, means, errors = 1 << 16, [], []
    wi, wo = jit.Array3f(0, 0, 1), jit.Array3f(0.6, 0, 0.8)
    bottom = KINDS["diffuse"].bottom(jit.Float(0.5))
    for sigma_t in (0.0, 2.0):
        rng = stream(jit.PCG32, dr.arange(jit.UInt64, walks), 0)
        f = walk.estimate(ForwardCoat(jit, sigma_t, g), bottom, wi, wo, rng, jit.Array3f)
        rows = np.array([channel.numpy() for channel in f])
        means.append(rows.mean(axis=1))
        errors.append(rows.std(axis=1) / walks**0.5)
    np.testing.assert_array_less(np.abs(means[1] - means[0]), 5 * np.hypot(*errors))


@pytest.mark.parametrize("g", [0.0, 0.5])
def test_a_scattering_medium_of_index_one_is_the_doubled_slab(g: float) -> None:
    """Its reflection over black, and its transmission without a bottom. Doubling has 0.01 %."""
    grid = CosineGrid.gauss(nodes=16, modes=48)
    first, second = (x.ravel() for x in np.indices((16, 16))[:, 4::4, 5::4])  # no straight light
    phi = np.linspace(0, np.pi, len(first))
    # The series' azimuth is that between directions of propagation.
    wi, wo = at_cosines(grid.mu[first]), at_cosines(grid.mu[second], np.pi - phi)
    coefficients = (0.3, 1, 0.9, 2.0, g)
    stacks = coat(diffuse(0), *coefficients), slab(*coefficients)
    for modes, stack, side in zip(
        doubling.slab(grid, *coefficients[2:]), stacks, (1, DOWN), strict=True
    ):
        expected = series(modes[:, first, second], phi) / (grid.root[first] * grid.root[second])
        f, se = simulate(stack, wi, wo * side, walks=1 << 14, seed=3)
        error = np.abs(f[:, 0] - expected)
        np.testing.assert_array_less(error, 4.5 * se[:, 0] + 1e-3 * expected)


GRID = CosineGrid.gauss(nodes=24, modes=1)
IDENTITY = np.eye(24)
#: A perfect diffuser in the weighted form of doubling.
DIFFUSER = np.outer(GRID.root, GRID.root) / (GRID.root @ GRID.root)


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
        return [modes[0] for modes in doubling.slab(GRID, 1.0, sigma_t, g)]

    depth, number = depth / (1 - max(g, 0)), backend().Float
    short = medium.Medium.of(number(1), number(depth), number(g))
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
        assert not medium.Medium.of(number(albedo), number(depth), number(g)).deep[0]
    for albedo, least, deep in ((1, 20, True), (1, 5, False), ((1, 0.9, 1), 20, False)):
        albedo = color(*albedo) if isinstance(albedo, tuple) else color(albedo)
        assert medium.Medium.of(albedo, color(least, 50, 1e4), color(0)).deep[0] == deep
    deepest = medium.Medium.of(color(1), color(1e6, 0, 10), color(0.5)).sigma_t  # ends, in time
    np.testing.assert_allclose(deepest.numpy().ravel(), [2 * medium.DEEPEST, 0, 10], rtol=1e-5)
