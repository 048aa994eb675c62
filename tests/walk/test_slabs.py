"""Slabs, which transmit: closed forms, two other methods, conservation and reciprocity."""

import dataclasses

import numpy as np
import pytest
from tests.oracles import slab as closed
from tests.oracles.adding_doubling import surfaces
from tests.oracles.analog import analog_albedo

from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.walk import Stack, coat, dielectric, diffuse, simulate, slab
from urushi.walk.simulate import albedo

THETA = np.radians(np.linspace(2, 74, 10))
ABOVE = np.stack([0.6 * np.sin(THETA), 0.8 * np.sin(THETA), np.cos(THETA)], axis=1)
BELOW = ABOVE * [1, 1, -1]
DOWN = np.array([1, 1, -1], np.float32)
MEDIUM = {"albedo": (0.9, 0.5, 1.0), "sigma_t": (1.0, 0.3, 2.0), "g": (0.3, 0.0, -0.4)}

SLABS = {
    "pane": slab(0.1, 1.5, sigma_t=(0.0, 0.5, 2.0)),
    "paper": slab(0.4, 1.4, **MEDIUM),
    "on water": slab(0.2, 1.5, **MEDIUM, far=dielectric(0.3, 1.33 / 1.5)),
    "glass body": coat(dielectric(0.2, 1.5), 0.1, 1.3, **MEDIUM),
    "thinner": slab(0.2, 0.7, **MEDIUM),
    "no surface above": slab(0.1, 1.0, **MEDIUM, far=dielectric(0.3, 1.5)),
    "no surface below": slab(0.1, 1.5, **MEDIUM, far=dielectric(0.3, 1.0)),
    "brushed": slab(None, 1.5, **MEDIUM, far=dielectric(0.3, 0.7), alpha_u=0.1, alpha_v=0.4),
    "brushed below": slab(0.2, 1.5, **MEDIUM, far=dielectric(eta=0.7, alpha_u=0.1, alpha_v=0.4)),
    "three": coat(coat(slab(0.3, 0.9, **MEDIUM), 0.2, 1.4), 0.1, 1.2, 0.9, 0.5),
}
every_slab = pytest.mark.parametrize("stack", SLABS.values(), ids=SLABS.keys())


def upside_down(stack: Stack) -> Stack:
    """The description of the same slab, seen from below."""
    surfaces = [(part.alpha, 1 / np.asarray(part.eta)) for part in (*stack.coats, stack.bottom)]
    alphas, etas = zip(*surfaces[::-1], strict=True)
    coats = [
        dataclasses.replace(coat, alpha=alpha, eta=eta)
        for coat, alpha, eta in zip(stack.coats[::-1], alphas[:-1], etas[:-1], strict=True)
    ]
    return Stack(tuple(coats), dataclasses.replace(stack.bottom, alpha=alphas[-1], eta=etas[-1]))


@pytest.mark.parametrize("far", [1.0, 1.7])
def test_smooth_clear_slabs_are_fresnels_sums_and_lose_nothing(far: float) -> None:
    stack, options = slab(0.01, 1.5, far=dielectric(0.01, far / 1.5)), dict(walks=1 << 16, seed=1)
    below = np.cos(THETA) if far == 1 else np.cos(np.arcsin(np.sin(THETA) / far))
    from_below = np.stack([np.sqrt(1 - below**2), 0 * below, -below], axis=1)
    total = []
    for wi, indices in ((ABOVE, (1.5, far)), (from_below, (1.5 / far, 1 / far))):
        expected = closed.free(np.abs(wi[:, 2]), *indices, 0.0)
        assert np.abs(sum(expected) - 1).max() < 1e-12
        shares = [albedo(stack, wi, **options, transmitted=passed) for passed in (False, True)]
        for (share, se), truth in zip(shares, expected, strict=True):
            # 1 %: GGX's tails, see `test_slab`. Closer to total reflection facets are less alike.
            far_from_grazing = THETA < 0.9
            error = np.abs(share[:, 0] - truth) - 5 * se[:, 0]
            assert np.all(error[far_from_grazing] < 0.01 * truth[far_from_grazing])
        total.append(shares[0][0][:, 0] + shares[1][0][:, 0])
        error = np.hypot(shares[0][1], shares[1][1])[:, 0]
        assert np.all(np.abs(total[-1] - 1) < 1e-3 + 5 * error)
        assert np.hypot.reduce(error) / len(error) < 4e-3
    assert np.mean(total) == pytest.approx(1, abs=6e-3)


@pytest.mark.parametrize(
    ("stack", "angles"),
    [
        (slab(0.4, 1.0, 1.0, (0.5, 2.0, 8.0), (0.0, 0.8, -0.5)), (0, 89)),
        (slab(0.01, 1.5), (0, 60)),
        (slab(0.01, 1.5, far=dielectric(0.01, 1.33 / 1.5)), (0, 50)),
        (coat(slab(0.01, 1.6), 0.01, 1.2), (0, 50)),
    ],
)
def test_lossless_slabs_keep_the_light_from_both_sides(stack: Stack, angles) -> None:
    theta = np.radians(np.linspace(*angles, 10))
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=1)
    for side in (stack, upside_down(stack)):
        # Photons are counted on both sides, so that the sum has no noise but what it misses.
        kept, _ = analog_albedo(side, wi, walks=1 << 16, seed=15, transmitted=None)
        # Facets of alpha = 0.01 hide a little light from each other, most of it near the horizon.
        assert np.all(np.abs(kept - 1) < 1e-3)


@pytest.mark.parametrize("far", [1.0, 1.33])
def test_smooth_absorbing_slabs_follow_beer_and_lambert(far: float) -> None:
    stack = slab(0.01, 1.5, sigma_t=(0.1, 0.5, 2.0), far=dielectric(0.01, far / 1.5))
    share, se = albedo(stack, ABOVE, walks=1 << 16, seed=2, transmitted=True)
    for channel, depth in enumerate((0.1, 0.5, 2.0)):
        _, expected = closed.free(ABOVE[:, 2], 1.5, far, depth)
        assert np.all(np.abs(share - expected[:, None])[:, channel] < 0.01 + 5 * se[:, channel])


@every_slab
def test_the_shares_agree_with_the_analog_walk_from_both_sides(stack: Stack) -> None:
    wi, options = ABOVE[::3], dict(walks=1 << 15, seed=3)
    for side, seen in ((wi, stack), (wi * DOWN, upside_down(stack))):
        for passed in (False, True):
            share, se = albedo(stack, side, **options, transmitted=passed)
            counted, error = analog_albedo(seen, wi, **options, transmitted=passed)
            if passed and all(part.eta == 1 for part in (*stack.coats, stack.bottom)):
                continue
            z = (share - counted) / np.maximum(np.hypot(se, error), 1e-9)
            assert np.abs(z).max() < 4.8  # 12 values, 10 slabs, 4 cases: Gaussian 4.1
            assert np.mean(z**2) < 2.6  # four standard deviations of 12 values


@every_slab
def test_slabs_are_reciprocal_with_the_squares_of_the_indices(stack: Stack) -> None:
    wi, wo = cosine_pairs(np.random.default_rng(4), 24)
    wi[::4] *= DOWN
    wo[1::2] *= DOWN  # reflected on both sides, transmitted in both directions
    one, se = simulate(stack, wi, wo, walks=1 << 12, seed=4, progress=False)
    other, error = simulate(stack, wo, wi, walks=1 << 12, seed=5, progress=False)
    beyond = stack.index**2
    square_i, square_o = (np.where(w[:, 2:] > 0, 1, beyond) for w in (wi, wo))
    z = (one / square_i - other / square_o) / np.hypot(se / square_i, error / square_o).clip(1e-7)
    assert np.abs(z).max() < 6  # walks of few have longer tails than a Gaussian
    assert (one > 0).mean() > 0.9
    # The power of light, as importance carries it, is symmetric too with the indices of the sides.
    power, _ = simulate(stack, wi, wo, walks=1 << 12, seed=4, progress=False, mode="importance")
    np.testing.assert_allclose(power, one * square_o / square_i, rtol=1e-5)


@every_slab
def test_a_slab_from_below_is_the_slab_upside_down(stack: Stack) -> None:
    wi, wo = cosine_pairs(np.random.default_rng(6), 24)
    wi[::2] *= DOWN
    f, se = simulate(stack, wi, wo, walks=1 << 12, seed=6, progress=False)
    turned = upside_down(stack)
    g, error = simulate(turned, wi * DOWN, wo * DOWN, walks=1 << 12, seed=7, progress=False)
    assert (np.abs(f - g) / np.hypot(se, error).clip(1e-7)).max() < 6


@pytest.mark.parametrize("eta", [1.5, 0.7])
@pytest.mark.parametrize("medium", [0.0, 0.4])
def test_one_rough_surface_is_walters_btdf(eta: float, medium: float) -> None:
    wi, wo = cosine_pairs(np.random.default_rng(8), 60)
    expected = eta**2 * surfaces.at_pairs(surfaces.transmission(0.3, eta), wi, wo)
    for stack, inside in (
        (coat(dielectric(0.3, eta), 0.6, 1.0, sigma_t=medium), wi),
        (coat(dielectric(0.6, 1.0), 0.3, eta, sigma_t=medium), wo),
    ):
        f, _ = simulate(stack, wi, wo * DOWN, walks=64, progress=False, mode="importance")
        passed = np.exp(-medium / inside[:, 2])
        np.testing.assert_allclose(f[:, 0], expected * passed, rtol=2e-3, atol=1e-5)


def test_the_delta_through_equal_indices_is_all_that_f_leaves_out() -> None:
    medium, wi = slab(0.3, 1, 1.0, (0.0, 0.5, 2.0), 0.3), ABOVE[::3]
    reflected, se = albedo(medium, wi, walks=1 << 16, seed=9)
    passed, error = albedo(medium, wi, walks=1 << 16, seed=9, transmitted=True)
    straight = np.exp(-np.array([0.0, 0.5, 2.0]) / wi[:, 2:])
    missing = np.abs(reflected + passed + straight - 1)
    assert np.all(missing < 1e-5 + 5 * np.hypot(se, error))


def test_as_depth_grows_a_slab_becomes_opaque() -> None:
    wi, wo = cosine_pairs(np.random.default_rng(10), 24)
    options = dict(walks=1 << 12, seed=11, progress=False)
    passed = [
        simulate(slab(0.3, 1.5, 0.9, depth), wi, wo * DOWN, **options)[0].mean()
        for depth in (1.0, 4.0, 16.0)
    ]
    assert passed[0] > 3 * passed[1] > 1000 * passed[2]
    f, se = simulate(slab(0.3, 1.5, 0.9, 40.0), wi, wo, **options)
    black, error = simulate(coat(diffuse(0), 0.3, 1.5, 0.9, 40.0), wi, wo, **options)
    assert (np.abs(f - black) / np.hypot(se, error)).max() < 4.5


def test_a_slab_laid_on_a_lambertian_is_the_coat_on_it() -> None:
    """f = R(wi, wo) + rho / pi T(wi) T(wo) / (1 - rho M), M the mean of R from below."""
    rho, options = 0.7, dict(walks=1 << 14, seed=12, progress=False)
    medium = dict(albedo=0.8, sigma_t=0.5, g=0.3)
    free, coated = (
        slab(0.2, 1.5, **medium, far=dielectric(0.2, 1)),
        coat(diffuse(rho), 0.2, 1.5, **medium),
    )
    wi, wo = ABOVE[::2], ABOVE[::-2] * [-1, 1, 1]
    nodes, weights = np.polynomial.legendre.leggauss(16)
    cos, weights = (nodes + 1) / 2, weights / 2 * (nodes + 1)
    inside = np.stack([np.sqrt(1 - cos**2), 0 * cos, -cos], axis=1)
    back = weights @ albedo(free, inside, walks=1 << 15, seed=13)[0][:, 0]
    # T counts light from wi that arrives below; reciprocity gives that to wo by the index squared.
    down, up = (
        albedo(free, w, walks=1 << 18, seed=14, transmitted=True)[0][:, 0] for w in (wi, wo)
    )
    reflected, se = simulate(free, wi, wo, **options)
    expected = reflected[:, 0] + rho / np.pi * down * up / 1.5**2 / (1 - rho * back)
    f, error = simulate(coated, wi, wo, **options)
    # Each T has a standard error of up to 0.6 %.
    np.testing.assert_array_less(
        np.abs(f[:, 0] - expected), 0.03 * expected + 4.5 * np.hypot(se, error)[:, 0]
    )


def test_bad_input_is_named() -> None:
    with pytest.raises(ParameterError, match="the far side of a slab is a Diffuse, not an interf"):
        slab(0.1, 1.5, far=diffuse(0.5))
    with pytest.raises(ParameterError, match="a Diffuse bottom is opaque; only urushi.slab"):
        albedo(coat(diffuse(0.5)), ABOVE, transmitted=True)
    for eta in (0.0, -1.5):
        with pytest.raises(ParameterError, match="the slab's eta is .*; it must be an index of"):
            slab(0.1, eta)
    with pytest.raises(ParameterError, match="sigma_t is inf; it must be an optical depth"):
        slab(0.1, 1.5, sigma_t=np.inf)
    with pytest.raises(ParameterError, match="mode is 'flux'; give 'radiance' or 'importance'"):
        simulate(SLABS["pane"], ABOVE, BELOW, mode="flux")
