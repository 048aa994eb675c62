"""The rough dielectric interface: its samplers."""

import math

import drjit as dr
import numpy as np
import pytest

from urushi.checks import Widths
from urushi.core.microfacet import of_widths
from urushi.walk import interface

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


every_case = pytest.mark.parametrize(("alpha", "eta", "theta"), CASES)


def memory(jit, alpha, eta: float, theta: float, suffix: str = "") -> tuple:
    """A direction above the surface, width and index in memory, with `suffix` 64 as doubles.

    One kernel serves all values, as it does not for constants in code.
    """
    number, vector = (getattr(jit, name + suffix) for name in ("Float", "Array3f"))
    sin = math.sin(theta)
    wi = vector(*(dr.opaque(number, x) for x in (sin * 0.6, sin * 0.8, math.cos(theta))))
    return wi, of_widths(lambda x: dr.opaque(number, x), alpha), dr.opaque(number, eta)


def uniform(jit, count: int):
    """Arrays of uniform numbers."""
    u = np.random.default_rng(0).random((count, COUNT), dtype=np.float32)
    return [jit.Float(x) for x in u]


@pytest.mark.parametrize("transmitted", [False, True])
@every_case
def test_samples_follow_the_stated_density(jit, sphere_test, alpha, eta, theta, transmitted):
    """Of both kinds of light, and of transmitted light alone."""
    wi, a, e = memory(jit, alpha, eta, theta)
    sample = interface.sample_transmission if transmitted else interface.sample
    density = interface.transmission if transmitted else interface.scatter
    wo, weight, *_ = sample(wi, a, e, *uniform(jit, 2 if transmitted else 3))
    samples = wo.numpy().T.copy()
    samples[weight.numpy() == 0] = np.nan

    def pdf(points: np.ndarray) -> np.ndarray:
        return density(wi, jit.Array3f(np.ascontiguousarray(points.T)), a, e)[1].numpy()

    assert sphere_test(samples, pdf) > 1e-4  # the smallest of some sixteen


@every_case
def test_a_sample_carries_f_cos_over_its_density(jit, alpha, eta, theta):
    """In double precision: the half vector, from wi + eta wo, may cancel most of single's digits.

    A weight is the masking of wo: no sample gains energy.
    """
    wi, a, e = memory(jit, alpha, eta, theta, "64")
    wo, weight, pdf = interface.sample(wi, a, e, *map(jit.Float64, uniform(jit, 3)))
    f, density = interface.scatter(wi, wo, a, e)
    kept = weight.numpy() > 0
    assert kept.mean() > 0.5 and weight.numpy().max() <= 1
    for found, expected in ((density, pdf), (f * dr.abs(wo.z), weight * pdf)):
        np.testing.assert_allclose(found.numpy()[kept], expected.numpy()[kept], rtol=1e-9)
