"""The rough dielectric interface: samplers, reciprocity between its two sides, and energy."""

import math
from types import ModuleType

import drjit as dr
import numpy as np
import pytest

from urushi.checks import Widths
from urushi.walk import interface
from urushi.walk.monte_carlo import backend

COUNT = 200_000

#: (alpha or two widths, eta, polar angle); eta < 1 is the view from the denser side, with total
#: reflection.
CASES = [
    (0.05, 0.5, 0.5),
    (0.3, 0.95, 1.4),
    (0.3, 1.5, 0.3),
    (0.8, 1 / 2.5, 1.2),
    (1.0, 3.0, 1.5),
    (Widths(0.5, 0.12), 1.5, 0.9),
    (Widths(0.15, 0.7), 1 / 1.5, 0.6),
    (Widths(1.0, 0.25), 2.5, 1.4),
]


@pytest.fixture(scope="module")
def jit() -> ModuleType:
    """The backend's array types."""
    return backend()


def number(jit: ModuleType, value: float, double: bool = False):
    """A number in memory: one kernel serves all values, as it does not for a constant in code."""
    return dr.opaque(jit.Float64 if double else jit.Float, value)


def direction(jit: ModuleType, theta: float, double: bool = False):
    """A unit vector above the surface."""
    sin = math.sin(theta)
    numbers = (number(jit, x, double) for x in (sin * 0.6, sin * 0.8, math.cos(theta)))
    return (jit.Array3f64 if double else jit.Array3f)(*numbers)


def width(jit: ModuleType, alpha: float | Widths, double: bool = False):
    """A GGX width, or two of them."""
    if isinstance(alpha, Widths):
        return alpha.map(lambda one: number(jit, one, double))
    return number(jit, alpha, double)


def uniform(jit: ModuleType, count: int, seed: int = 0):
    """Arrays of uniform numbers."""
    u = np.random.default_rng(seed).random((count, COUNT), dtype=np.float32)
    return [jit.Float(x) for x in u]


def arrays(jit: ModuleType, points: np.ndarray):
    """Dr.Jit vectors from (N, 3)."""
    return jit.Array3f(np.ascontiguousarray(points.T))


@pytest.mark.parametrize("transmitted", [False, True])
@pytest.mark.parametrize(("alpha", "eta", "theta"), CASES)
def test_samples_follow_the_stated_density(
    jit: ModuleType, sphere_test, alpha: float | Widths, eta: float, theta: float, transmitted: bool
) -> None:
    """Of both kinds of light, and of transmitted light alone."""
    wi, a, e = direction(jit, theta), width(jit, alpha), number(jit, eta)
    sample = interface.sample_transmission if transmitted else interface.sample
    density = interface.transmission if transmitted else interface.scatter
    wo, weight, *_ = sample(wi, a, e, *uniform(jit, 2 if transmitted else 3))
    samples = wo.numpy().T.copy()
    samples[weight.numpy() == 0] = np.nan

    def pdf(points: np.ndarray) -> np.ndarray:
        return density(wi, arrays(jit, points), a, e)[1].numpy()

    assert sphere_test(samples, pdf) > 1e-4  # the smallest of some sixteen


@pytest.mark.parametrize(("alpha", "eta", "theta"), CASES)
def test_a_sample_carries_f_cos_over_its_density(
    jit: ModuleType, alpha: float | Widths, eta: float, theta: float
) -> None:
    """In double precision: the half vector, from wi + eta wo, may cancel most of single's digits.

    A weight is the masking of wo: no sample gains energy.
    """
    wi, a, e = direction(jit, theta, double=True), width(jit, alpha, True), number(jit, eta, True)
    wo, weight, pdf = interface.sample(wi, a, e, *map(jit.Float64, uniform(jit, 3)))
    f, density = interface.scatter(wi, wo, a, e)
    kept = weight.numpy() > 0
    assert kept.mean() > 0.5 and weight.numpy().max() <= 1
    for found, expected in ((density, pdf), (f * dr.abs(wo.z), weight * pdf)):
        np.testing.assert_allclose(found.numpy()[kept], expected.numpy()[kept], rtol=1e-9)


@pytest.mark.parametrize(("alpha", "eta", "theta"), CASES)
def test_split_sampling_adds_up_to_both(
    jit: ModuleType, alpha: float | Widths, eta: float, theta: float
) -> None:
    # Fresnel as a weight, summed over the two choices, is Fresnel as a probability.
    wi, a, e = direction(jit, theta), width(jit, alpha), number(jit, eta)
    u0, u1, u2 = uniform(jit, 3)
    _, both, _ = interface.sample(wi, a, e, u0, u1, u2)
    split = sum(
        sample(wi, a, e, u1, u2)[1].numpy()
        for sample in (interface.sample_reflection, interface.sample_transmission)
    )
    difference = both.numpy() - split
    assert abs(difference.mean()) < 4 * difference.std() / np.sqrt(COUNT) + 1e-5


@pytest.mark.parametrize("eta", [0.5, 0.7, 0.95, 1.1, 1.5, 3.0])
@pytest.mark.parametrize("alpha", [0.05, 0.5, Widths(0.1, 0.5)])
def test_transmission_up_and_down_differ_by_the_squared_index(
    jit: ModuleType, alpha: float | Widths, eta: float
) -> None:
    # In flux convention f(up) = f(down) / eta^2 (Veach 1997, section 5.2, with light's eta^2 out).
    above, a = direction(jit, 0.8), width(jit, alpha)
    below, weight = interface.sample_transmission(above, a, number(jit, eta), *uniform(jit, 2))
    below = dr.select(weight > 0, below, jit.Array3f(0, 0, -1))  # failed: total reflection, masking
    down, _ = interface.transmission(above, below, a, number(jit, eta))
    flip = interface.flip
    up, _ = interface.transmission(flip(below), flip(above), a, number(jit, 1 / eta))
    down, up = down.numpy(), up.numpy()
    lit = down > 0.01 * down.max()
    np.testing.assert_allclose(up[lit] * eta**2, down[lit], rtol=5e-3)


@pytest.mark.parametrize("eta", [1.5, 1 / 1.5])
def test_a_smooth_interface_loses_no_energy(jit: ModuleType, eta: float) -> None:
    wi = direction(jit, 0.5)
    _, weight, _ = interface.sample(wi, number(jit, 0.01), number(jit, eta), *uniform(jit, 3))
    # Single scattering loses the light that facets hide from each other, of order alpha^2.
    assert weight.numpy().mean() > 1 - 1e-3


def test_reflection_below_the_horizon_is_dark(jit: ModuleType) -> None:
    wi, a, e = direction(jit, 0.5), jit.Float(0.3), jit.Float(1.5)
    below = interface.flip(wi)
    assert interface.reflection(wi, below, a, e).numpy()[0] == 0
    assert interface.reflection(below, wi, a, e).numpy()[0] == 0
    assert interface.transmission(wi, wi, a, e)[0].numpy()[0] == 0
