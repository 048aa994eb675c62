"""What has a closed form: bare surfaces, smooth coats and slabs, and media without an interface."""

import functools

import numpy as np
import pytest
from tests.directions import DOWN, at_cosines, in_plane, pairs_above
from tests.oracles import slab as closed
from tests.oracles import surfaces

from urushi.checks import Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.walk import analytic, coat, conductor, dielectric, diffuse, simulate, slab
from urushi.walk.simulate import albedo
from urushi.walk.table import from_stack

SIGMA_T = (0.0, 0.25, 0.5)
REFLECTANCE = (0.9, 0.6, 0.5)
MEDIUM = {"albedo": (0.9, 0.5, 1.0), "g": 0.3}


PAIRS = cosine_pairs(np.random.default_rng(8), 60)


@pytest.mark.parametrize(
    "surface",
    [
        conductor((0.01, 0.5, 1.0), (0.04, 0.5, 1.0)),
        conductor((0.01, 0.3, 1.0), eta=(0.1, 0.9, 4.0), k=(9.0, 2.4, 0.1)),
        dielectric(0.2, (1.1, 1.5, 3.0)),
        conductor(alpha_u=0.5, alpha_v=(0.1, 0.6, 1.0), r0=0.5),
        dielectric(eta=0.7, alpha_u=(0.02, 0.1, 0.8), alpha_v=0.1),
        diffuse((0.1, 0.5, 1.0)),
    ],
)
def test_surfaces_without_coats_are_reciprocal_and_follow_their_formulas(surface) -> None:
    wi, wo = pairs_above(500, 6, 0.05)
    f, table = analytic.f(surface, wi, wo), from_stack(surface)
    assert f.dtype == np.float32 and f.shape == (500, 3)
    np.testing.assert_allclose(f, analytic.f(surface, wo, wi), rtol=1e-5)
    for channel, numbers in enumerate(zip(*table.bottom.values(), strict=True)):
        expected = surfaces.bottom(table.kind, wi, wo, *map(float, numbers))
        np.testing.assert_allclose(f[:, channel], expected, rtol=3e-4)
    for sides in ((wi, wo * DOWN), (wi * DOWN, wo), (wi * DOWN, wo * DOWN)):
        assert not analytic.f(surface, *sides).any()


@pytest.mark.parametrize("eta", [0.95, 0.999, 1.001, 1.5])
def test_smooth_coats_on_a_lambertian(eta: float) -> None:
    """At 20 to 60 degrees, with half vectors 10 degrees or more from the normal."""
    cosines = [np.cos(x.ravel()) for x in np.meshgrid(*2 * [[0.35, 0.7, 1.05]])]
    # The half vector is tilted at a right angle to the plane of incidence.
    wi, wo = at_cosines(cosines[0]), at_cosines(cosines[1], np.pi / 2)
    stack = coat(diffuse(REFLECTANCE), 0.01, eta, albedo=0.0, sigma_t=SIGMA_T)
    f, se = simulate(stack, wi, wo, walks=20_000, seed=1)
    for channel, medium in enumerate(zip(SIGMA_T, REFLECTANCE, strict=True)):
        expected = closed.lambertian_f(wi[:, 2], wo[:, 2], eta, *medium)
        # 1 %: GGX has long tails, so that even alpha = 0.01 is not quite smooth.
        error = np.abs(f[:, channel] - expected)
        assert np.all(error < 0.01 * expected + 4 * se[:, channel])
        assert np.median(f[:, channel] / expected) == pytest.approx(1, abs=5e-3)


@pytest.mark.parametrize("eta", [1.5, 0.7])
def test_smooth_coats_on_a_mirror(eta: float) -> None:
    """Below an index of one, the last direction is reflected totally."""
    wi = in_plane([5.0, 35.0, 65.0])
    stack = coat(conductor(0.01, REFLECTANCE), 0.01, eta, albedo=0.0, sigma_t=SIGMA_T)
    found, se = albedo(stack, wi, walks=1 << 16, seed=3)
    for channel, (depth, r0) in enumerate(zip(SIGMA_T, REFLECTANCE, strict=True)):
        below = functools.partial(surfaces.fresnel_schlick, r0=r0)
        expected, _ = closed.smooth(wi[:, 2], eta, depth, below)
        # 1 %: light that GGX's tails reflect below the horizon is lost. Of total reflection they
        # mask less, and tilt 2e-4 of the facets by more than the 20 degrees to spare.
        allowed = np.where(expected == 1, 2e-3, 0.01 * expected) + 5 * se[:, channel]
        assert np.all(np.abs(found[:, channel] - expected) < allowed)


@pytest.mark.parametrize("far", [1.0, 1.33, 1.7])
def test_smooth_slabs_are_fresnels_sums_and_follow_beer_and_lambert(far: float) -> None:
    """Reflected and transmitted light, from both sides."""
    theta, depths = np.radians(np.linspace(2, 74, 10)), (0.0, 0.5, 2.0)
    stack = slab(0.01, 1.5, sigma_t=depths, far=dielectric(0.01, far / 1.5))
    below = np.cos(theta if far == 1 else np.arcsin(np.sin(theta) / far))
    for wi, indices in (
        (at_cosines(np.cos(theta)), (1.5, far)),
        (at_cosines(below) * DOWN, (1.5 / far, 1 / far)),
    ):
        shares = [albedo(stack, wi, walks=1 << 16, seed=1, transmitted=x) for x in (False, True)]
        for channel, depth in enumerate(depths):
            below = functools.partial(closed.interface_reflectance, eta=indices[1] / indices[0])
            expected = closed.smooth(np.abs(wi[:, 2]), indices[0], depth, below)
            for (share, se), truth in zip(shares, expected, strict=True):
                # 1 %: GGX's tails. Closer to total reflection facets are less alike.
                error = np.abs(share[:, channel] - truth) - 5 * se[:, channel]
                assert np.all((error < 0.01 * truth) | (theta > 0.9))
        total = shares[0][0][:, 0] + shares[1][0][:, 0]
        error = np.hypot(shares[0][1], shares[1][1])[:, 0]
        assert np.all(np.abs(total - 1) < 1e-3 + 5 * error)
        assert total.mean() == pytest.approx(1, abs=6e-3)


@pytest.mark.parametrize("eta", [1.5, 0.7])
@pytest.mark.parametrize("medium", [0.0, 0.4])
def test_one_rough_surface_transmits_by_walters_btdf(eta: float, medium: float) -> None:
    wi, wo = PAIRS
    expected = eta**2 * surfaces.transmission(wi, wo * DOWN, 0.3, eta)
    for stack, inside in (
        (coat(dielectric(0.3, eta), 0.6, 1.0, sigma_t=medium), wi),
        (coat(dielectric(0.6, 1.0), 0.3, eta, sigma_t=medium), wo),
    ):
        f, _ = simulate(stack, wi, wo * DOWN, walks=64, progress=False, mode="importance")
        passed = np.exp(-medium / inside[:, 2])
        np.testing.assert_allclose(f[:, 0], expected * passed, rtol=2e-3, atol=1e-5)


@pytest.mark.parametrize("alpha", [0.01, 0.5, Widths(0.1, 0.8)])
def test_an_absorbing_medium_of_index_one_is_beers_law(alpha) -> None:
    depth, inverse = np.array([0.0, 0.3, 1.2]), 1 / PAIRS[0][:, 2] + 1 / PAIRS[1][:, 2]
    f, _ = simulate(coat(diffuse(0.5), alpha, 1, sigma_t=tuple(depth)), *PAIRS, walks=64)
    expected = 0.5 / np.pi * np.exp(-inverse[:, None] * depth)
    np.testing.assert_allclose(f, expected, rtol=1e-4)


@pytest.mark.parametrize(
    "bottom",
    [
        conductor(0.05, (0.9, 0.5, 0.2)),
        conductor(0.6, eta=0.143, k=3.983, energy_compensation=True),
        dielectric(0.2, 1.5),
        dielectric(0.2, 1),
    ],
)
def test_no_interface_and_no_medium_is_the_bottom(bottom) -> None:
    for stack in (coat(bottom, 0.4, 1), coat(coat(bottom, 0.4, 1), 0.02, 1)):
        f, _ = simulate(stack, *PAIRS, walks=16)
        np.testing.assert_allclose(f, analytic.f(bottom, *PAIRS), rtol=1e-5)


@pytest.mark.parametrize("outer", [1.5, 1.0])
def test_media_of_one_index_are_one_medium(outer: float) -> None:
    """At 1.5 the interface of index 1 is between the media, otherwise on top of all."""
    bottom, walks = conductor(0.3, 0.8), 1 << 13
    inner = coat(bottom, 0.4, 1, sigma_t=0.4, **MEDIUM)
    once, twice = (
        coat(below, 0.1, outer, sigma_t=depth, **MEDIUM)
        for below, depth in ((bottom, 1.0), (inner, 0.6))
    )
    (f, se), (expected, error) = (simulate(s, *PAIRS, walks=walks) for s in (twice, once))
    np.testing.assert_array_less(np.abs(f - expected), 5 * np.hypot(se, error) + 1e-6)
    assert f.mean() == pytest.approx(expected.mean(), rel=0.01)


def test_the_delta_through_equal_indices_is_all_that_f_leaves_out() -> None:
    medium, wi = slab(0.3, 1, 1.0, (0.0, 0.5, 2.0), 0.3), in_plane([2.0, 26.0, 50.0, 74.0])
    reflected, se = albedo(medium, wi, walks=1 << 16, seed=9)
    passed, error = albedo(medium, wi, walks=1 << 16, seed=9, transmitted=True)
    straight = np.exp(-np.array([0.0, 0.5, 2.0]) / wi[:, 2:])
    missing = np.abs(reflected + passed + straight - 1)
    assert np.all(missing < 1e-5 + 5 * np.hypot(se, error))
