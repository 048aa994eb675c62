"""Directional albedos: two different estimators agree, and energy is conserved."""

import numpy as np
import pytest
from tests.oracles.analog import analog_albedo

from urushi.errors import ParameterError
from urushi.walk import coat, conductor, dielectric, diffuse
from urushi.walk.simulate import albedo

THETA = np.array([0.0, 0.6, 1.1, 1.45])
WI = np.stack([0.6 * np.sin(THETA), 0.8 * np.sin(THETA), np.cos(THETA)], axis=1)

STACKS = {
    "sharp over rough": coat(conductor(0.4, (0.9, 0.5, 0.1)), 0.02, 1.5, 0.8, (0.5, 2.0, 0.0)),
    "rough over sharp": coat(conductor(0.05, 0.9), 0.6, 1.7, (0.9, 0.5, 1.0), 1.0, 0.7),
    "complex index": coat(conductor(0.2, eta=(0.2, 0.9, 1.5), k=(3.9, 2.4, 1.9)), 0.1, 1.4),
    "leaking": coat(dielectric(0.3, 1.6), 0.2, 1.3, 0.99, 5.0, (-0.6, 0.0, 0.6)),
    "diffuse": coat(diffuse((1.0, 0.5, 0.1)), 1.0, 3.0, 0.95, 0.5),
    "thinner below": coat(conductor(0.2, (0.9, 0.5, 0.1)), 0.1, 0.7, 0.8, (0.5, 2.0, 0.0), 0.3),
    "thinner, rough": coat(diffuse(0.8), 0.6, 0.5, 0.95, (0.0, 1.0, 3.0), -0.5),
    "thinner inside": coat(coat(diffuse(0.9), 0.05, 0.94, 0.9, 0.5), 0.2, 1.6, 0.8, 0.3),
    "two coats": coat(
        coat(conductor(0.2, 0.8), 0.3, 1.2, (0.9, 0.99, 0.5), 2.0, 0.5), 0.15, 1.5, 0.8, 0.5, -0.4
    ),
    "brushed": coat(
        conductor(r0=(0.9, 0.5, 0.1), alpha_u=0.05, alpha_v=0.4), 0.1, 1.5, 0.8, (0.5, 2.0, 0.0)
    ),
    "brushed coat": coat(
        diffuse((0.9, 0.5, 0.1)), None, 1.4, 0.9, 0.5, 0.6, alpha_u=(0.6, 0.3, 0.1), alpha_v=0.1
    ),
    "crossed": coat(
        coat(conductor(r0=0.9, alpha_u=0.3, alpha_v=0.08), 0.2, 1.2, 0.9, 0.5),
        *(None, 1.5, 0.8, (0.0, 0.5, 2.0), -0.4),
        alpha_u=0.08,
        alpha_v=0.6,
    ),
    "four coats": coat(
        coat(coat(coat(diffuse(0.8), 0.1, 1.3, 0.9, 0.5), 0.5, 1.1), 0.2, 1.6, 1.0, 1.0, 0.9),
        *(0.4, 1.4, (0.9, 0.5, 0.0), 0.7),
    ),
}


@pytest.mark.parametrize("stack", STACKS.values(), ids=STACKS.keys())
def test_the_integral_of_the_brdf_agrees_with_the_analog_walk(stack) -> None:
    through_brdf, se = albedo(stack, WI, walks=1 << 14, seed=1)
    counted, se_counted = analog_albedo(stack, WI, walks=1 << 14, seed=2)
    z = (through_brdf - counted) / np.hypot(se, se_counted)
    assert np.abs(z).max() < 4.5  # 12 values of 13 stacks
    assert np.mean(z**2) < 1 + 4 * np.sqrt(2 / z.size)
    assert np.all(counted <= 1)
    assert np.all(through_brdf < 1 + 5 * se)
    assert np.median(np.hypot(se, se_counted) / counted) < 0.03  # the comparison is sharp


@pytest.mark.parametrize(
    ("bottom", "sigma_t", "eta"),
    [
        (conductor(0.01, 1.0), 0.0, 0.95),
        (conductor(0.01, 1.0), 2.0, 1.5),
        (diffuse(1.0), 0.0, 1.5),
        (diffuse(1.0), 2.0, 0.5),
    ],
)
def test_a_smooth_stack_that_absorbs_nothing_reflects_everything(
    bottom, sigma_t: float, eta: float
) -> None:
    stack = coat(bottom, 0.01, eta, 1.0, sigma_t, 0.3)
    value, se = albedo(stack, WI[:3], walks=1 << 16, seed=3)
    # Only the light that facets hide from each other is lost: alpha^2 = 1e-4 at each of the few
    # dozen reflections of light that is trapped in a coat.
    assert np.all(value > 0.99 - 5 * se)
    assert np.all(value < 1 + 5 * se)


def test_beyond_the_critical_angle_a_smooth_surface_reflects_everything() -> None:
    # sin(wi) = 0.89 is beyond eta = 0.7: neither the medium nor the bottom is reached.
    black = coat(diffuse(0.0), 0.01, 0.7, 0.0, 5.0)
    for estimate in (albedo, analog_albedo):
        value, se = estimate(black, WI[2:3], walks=1 << 16, seed=8)
        # GGX's tails: alpha = 0.01 tilts 2e-4 of the facets by more than the 18 degrees to spare,
        # and masks as much.
        assert np.all(np.abs(value - 1) < 2e-3 + 5 * se)
        value, se = estimate(black, WI[1:2], walks=1 << 16, seed=8)  # 34 degrees, of 44
        assert np.all(value < 0.2)


def test_rough_facets_lose_light_and_never_gain_any() -> None:
    lost = []
    for alpha in (0.05, 0.3, 1.0):
        stack = coat(conductor(alpha, 1.0), alpha, 1.5, 1.0, 1.0)
        value, se = albedo(stack, WI, walks=1 << 16, seed=4)
        assert np.all(value < 1 + 5 * se)
        lost.append(1 - value.mean())
    # The model has no scattering between facets, so its loss grows with roughness.
    assert lost[0] < lost[1] < lost[2]


def test_a_black_diffuse_bottom_leaves_only_the_top_reflection() -> None:
    top, se_top = albedo(coat(diffuse(0.0), 0.2, 1.5), WI, walks=1 << 16, seed=6)
    counted, se = analog_albedo(coat(diffuse(0.0), 0.2, 1.5, 0.0, 5.0), WI, walks=1 << 16, seed=7)
    assert np.abs((top - counted) / np.hypot(se, se_top)).max() < 4
    # An interface of alpha = 0.2 reflects like a smooth one from straight above.
    assert top[0] == pytest.approx(0.04, abs=0.002)


def test_directions_below_the_horizon_have_zero_albedo() -> None:
    value, se = albedo(STACKS["diffuse"], [[0, 0.6, -0.8], [1, 0, 0]], walks=100)
    assert not value.any()
    assert not se.any()


def test_directions_that_are_no_unit_vectors_are_named() -> None:
    with pytest.raises(ParameterError, match=r"wi\[0\] = .* is not a unit vector"):
        albedo(STACKS["diffuse"], [[0, 0, 2]])
