"""Laws of the walk for stacks and slabs: two estimators agree, reciprocity, both sides, energy."""

import dataclasses

import numpy as np
import pytest
from tests.directions import DOWN, at_cosines, pairs_above
from tests.oracles.analog import analog_albedo

from urushi.walk import Stack, coat, conductor, dielectric, diffuse, simulate, slab
from urushi.walk.simulate import albedo

WI = at_cosines(np.cos([0.0, 0.6, 1.1, 1.45]), np.arctan2(0.8, 0.6))
MEDIUM = {"albedo": (0.9, 0.5, 1.0), "sigma_t": (1.0, 0.3, 2.0), "g": (0.3, 0.0, -0.4)}
COLOR, METAL = (0.9, 0.5, 0.1), {"eta": (0.2, 0.9, 1.5), "k": (3.9, 2.4, 1.9)}

OPAQUE = {
    "sharp over rough": coat(conductor(0.4, COLOR), 0.02, 1.5, 0.8, (0.5, 2.0, 0.0)),
    "rough over sharp": coat(conductor(0.05, 0.9), 0.6, 1.7, (0.9, 0.5, 1.0), 1.0, 0.7),
    "complex index": coat(conductor(0.2, **METAL), 0.1, 1.4),
    "leaking": coat(dielectric(0.3, 1.6), 0.2, 1.3, 0.99, 5.0, (-0.6, 0.0, 0.6)),
    "diffuse": coat(diffuse((1.0, 0.5, 0.1)), 1.0, 3.0, 0.95, 0.5),
    "thinner below": coat(conductor(0.2, COLOR), 0.1, 0.7, 0.8, (0.5, 2.0, 0.0), 0.3),
    "thinner, rough": coat(diffuse(0.8), 0.6, 0.5, 0.95, (0.0, 1.0, 3.0), -0.5),
    "thinner inside": coat(coat(diffuse(0.9), 0.05, 0.94, 0.9, 0.5), 0.2, 1.6, 0.8, 0.3),
    "two coats": coat(
        coat(conductor(0.2, 0.8), 0.3, 1.2, (0.9, 0.99, 0.5), 2.0, 0.5), 0.15, 1.5, 0.8, 0.5, -0.4
    ),
    "no interface": coat(coat(diffuse(0.6), 0.2, 1.5, sigma_t=0.2), 0.9, 1.0, COLOR, 0.5),
    "four coats": coat(
        coat(coat(coat(diffuse(0.8), 0.1, 1.3, 0.9, 0.5), 0.5, 1.1), 0.2, 1.6, 1.0, 1.0, 0.9),
        *(0.4, 1.4, (0.9, 0.5, 0.0), 0.7),
    ),
    # Anisotropic at the top, at the bottom, at both, and with three interfaces
    "brushed coat": coat(
        diffuse(COLOR), None, 1.4, 0.9, 0.5, 0.6, alpha_u=(0.6, 0.3, 0.1), alpha_v=0.1
    ),
    "brushed": coat(conductor(r0=COLOR, alpha_u=0.05, alpha_v=0.4), 0.1, 1.5, 0.8, (0.5, 2.0, 0.0)),
    "crossed": coat(
        conductor(alpha_u=0.4, alpha_v=(0.1, 0.2, 0.3), **METAL), eta=1.6, alpha_u=0.1, alpha_v=0.6
    ),
    "crossed coats": coat(
        coat(dielectric(eta=1.8, alpha_u=0.2, alpha_v=0.6), 0.3, 1.2, 0.9, 0.5),
        *(None, 0.8, 0.9, (0.0, 0.3, 1.0), -0.5),
        alpha_u=0.7,
        alpha_v=0.2,
    ),
}
SLABS = {
    "pane": slab(0.3, 1.5, sigma_t=(0.0, 0.5, 2.0)),
    "paper": slab(0.4, 1.4, **MEDIUM),
    "on water": slab(0.2, 1.5, **MEDIUM, far=dielectric(0.3, 1.33 / 1.5)),
    "glass body": coat(dielectric(0.2, 1.5), 0.1, 1.3, **MEDIUM),
    "thinner slab": slab(0.2, 0.7, **MEDIUM),
    "no surface above": slab(0.1, 1.0, **MEDIUM, far=dielectric(0.3, 1.5)),
    "no surface below": slab(0.1, 1.5, **MEDIUM, far=dielectric(0.3, 1.0)),
    "brushed slab": slab(None, 1.5, **MEDIUM, far=dielectric(0.3, 0.7), alpha_u=0.1, alpha_v=0.4),
    "brushed below": slab(0.2, 1.5, **MEDIUM, far=dielectric(eta=0.7, alpha_u=0.1, alpha_v=0.4)),
    "three": coat(coat(slab(0.3, 0.9, **MEDIUM), 0.2, 1.4), 0.1, 1.2, 0.9, 0.5),
}
every = pytest.mark.parametrize("name", OPAQUE | SLABS)


def upside_down(stack: Stack) -> Stack:
    """The description of the same slab, seen from below."""
    surfaces = [(part.alpha, 1 / np.asarray(part.eta)) for part in (*stack.coats, stack.bottom)]
    alphas, etas = zip(*surfaces[::-1], strict=True)
    coats = [
        dataclasses.replace(coat, alpha=alpha, eta=eta)
        for coat, alpha, eta in zip(stack.coats[::-1], alphas[:-1], etas[:-1], strict=True)
    ]
    return Stack(tuple(coats), dataclasses.replace(stack.bottom, alpha=alphas[-1], eta=etas[-1]))


def run(stack: Stack, wi: np.ndarray, wo: np.ndarray, seed: int) -> np.ndarray:
    """f and its standard error, (2, N, 3)."""
    found = simulate(stack, wi, wo, walks=1 << 12, seed=seed, progress=False)
    return np.array(found, np.float64)


def assert_equal_means(one: np.ndarray, other: np.ndarray) -> None:
    """Two independent estimates (f, se) agree; rounding of analytic terms is allowed."""
    z = (one[0] - other[0]) / np.sqrt(one[1] ** 2 + other[1] ** 2 + (1e-5 * one[0]) ** 2 + 1e-14)
    # 100 values or more of long-tailed estimates, channels in part the same: z is wider than a
    # Gaussian.
    assert np.abs(z).max() < 6
    assert abs(z.mean()) < 4 / np.sqrt(len(z))
    assert np.mean(z**2) < 1.6


@every
def test_the_integral_of_f_agrees_with_the_analog_walk(name: str) -> None:
    """Of slabs, what is reflected and what is transmitted, from both sides."""
    stack = (OPAQUE | SLABS)[name]
    cases = [(stack, WI, stack, False)]
    if name in SLABS:
        turned = upside_down(stack)
        cases += [(stack, WI, stack, True)]
        cases += [(stack, WI * DOWN, turned, passed) for passed in (False, True)]
    for own, wi, seen, passed in cases:
        found, se = albedo(own, wi, walks=1 << 14, seed=1, transmitted=passed)
        counted, error = analog_albedo(seen, WI, walks=1 << 14, seed=2, transmitted=passed)
        z = (found - counted) / np.hypot(se, error).clip(1e-9)
        assert np.abs(z).max() < 4.8  # 12 values of 15 stacks and 40 cases of slabs: Gaussian 4.3
        assert np.mean(z**2) < 1 + 4 * np.sqrt(2 / z.size)
        assert np.all(counted <= 1)
        assert np.all(found < 1 + 5 * se)
        if name in OPAQUE:  # the comparison is sharp
            assert np.median(np.hypot(se, error) / counted) < 0.03


@every
def test_stacks_are_reciprocal(name: str) -> None:
    """With the squares of the indices of both sides."""
    stack, (wi, wo) = (OPAQUE | SLABS)[name], pairs_above(60, 1, 0.1)
    beyond = 1.0
    if name in SLABS:  # reflected on both sides, transmitted in both directions
        wi[::4] *= DOWN
        wo[1::2] *= DOWN
        beyond = stack.index**2
    square_i, square_o = (np.where(w[:, 2:] > 0, 1, beyond) for w in (wi, wo))
    one = run(stack, wi, wo, 4)
    assert_equal_means(one / square_i, run(stack, wo, wi, 5) / square_o)
    assert (one[0] > 0).mean() > 0.9
    if name in SLABS:
        # The power of light, as importance carries it, is symmetric with the indices of the sides.
        few = {"walks": 64, "seed": 4, "progress": False}
        light, _ = simulate(stack, wi, wo, **few)
        power, _ = simulate(stack, wi, wo, **few, mode="importance")
        np.testing.assert_allclose(power, light * square_o / square_i, rtol=1e-5)


@pytest.mark.parametrize(
    "stack",
    [
        coat(conductor(0.01, 1.0), 0.01, 0.95, 1.0),
        coat(conductor(0.01, 1.0), 0.01, 1.5, 1.0, 2.0, 0.3),
        coat(diffuse(1.0), 0.01, 1.5, 1.0),
        coat(diffuse(1.0), 0.01, 0.5, 1.0, 2.0, 0.3),
        slab(0.01, 1.5, albedo=1.0, sigma_t=2.0, g=0.3),
        coat(slab(0.01, 1.6), 0.01, 1.2),
    ],
)
def test_smooth_stacks_that_absorb_nothing_keep_all_light(stack: Stack) -> None:
    """Only the light that facets hide from each other is lost: alpha^2 = 1e-4 at each of the few
    dozen reflections of light that is trapped in a coat."""
    sides = [False, True] if isinstance(stack.bottom, type(dielectric())) else [False]
    shares = [albedo(stack, WI[:3], walks=1 << 16, seed=3, transmitted=side) for side in sides]
    kept, error = sum(x for x, _ in shares), sum(x for _, x in shares)
    assert np.all(kept > 0.99 - 5 * error)
    assert np.all(kept < 1 + 5 * error)
