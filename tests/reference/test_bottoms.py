"""Bottoms of the walk: their densities are those that their samples have, and limits are known."""

import drjit as dr
import numpy as np
import pytest

from urushi.data.distribution import Extended
from urushi.physics.frame import square_to_cosine_hemisphere
from urushi.reference import bottoms, device
from urushi.reference.rng import stream

SAMPLES = 1 << 20


@pytest.fixture(scope="module")
def types():
    return device.types()


def directions(types, theta):
    """Many copies of wi at an angle to the normal, and uniform numbers from a fixed stream."""
    wi = types.Array3f(float(np.sin(theta)), 0, float(np.cos(theta)))
    rng = stream(types.PCG32, dr.arange(types.UInt64, SAMPLES), 1)
    return wi + dr.zeros(types.Array3f, SAMPLES), rng


def mixtures(types, count):
    table = Extended(0, "mixture").sample(np.random.default_rng(3), count)
    for row in range(count):
        yield bottoms.LobeMixture(*(types.Float(float(v[row])) for v in table.bottom.values()))


@pytest.mark.parametrize("theta", [0.2, 1.2])
def test_mixture_weights_integrate_the_brdf_and_its_density(types, theta):
    """The mean weight is the albedo, and the density integrates to the share that succeeds."""
    for mixture in mixtures(types, 6):
        wi, rng = directions(types, theta)
        _, weight, pdf = mixture.sample(
            wi, rng.next_float32(), rng.next_float32(), rng.next_float32()
        )
        grid = square_to_cosine_hemisphere(types.Array3f, rng.next_float32(), rng.next_float32())
        f, density = mixture.f_pdf(wi, grid)
        mean, error = (f * dr.pi).numpy().mean(), (f * dr.pi).numpy().std() / SAMPLES**0.5
        # Four standard errors of either estimate; cosine sampling is the noisier one.
        assert abs(weight.numpy().mean() - mean) < 4 * error + 4 * weight.numpy().std() / 1024
        values = (density * dr.pi / grid.z).numpy()
        succeeded = (pdf > 0).numpy().mean()
        assert abs(values.mean() - succeeded) < 4 * values.std() / SAMPLES**0.5 + 2e-3


def test_mixture_of_one_lobe_is_that_lobe(types):
    wi, rng = directions(types, 0.7)
    wo = square_to_cosine_hemisphere(types.Array3f, rng.next_float32(), rng.next_float32())
    one, half, r0 = types.Float(1), types.Float(0.5), types.Float(0.3)
    zero = types.Float(0)
    lobe = bottoms.LobeMixture(zero, one, half, r0, zero, half, r0).f_pdf(wi, wo)[0]
    conductor = bottoms.schlick_conductor(half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(lobe.numpy(), conductor.numpy(), rtol=1e-5)
    diffuse = bottoms.LobeMixture(half, zero, half, r0, zero, half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(diffuse.numpy(), 0.5 / np.pi, rtol=1e-6)


def test_beckmann_lobe_is_mitsubas(variant):
    """Mitsuba's roughconductor without Fresnel is the same Beckmann lobe (r0 = 1)."""
    import mitsuba as mi

    bsdf = mi.load_dict(
        {"type": "roughconductor", "material": "none", "alpha": 0.3, "distribution": "beckmann"}
    )
    rng = np.random.default_rng(5)
    z = rng.uniform(0.05, 1, (2, 1000))
    phi = rng.uniform(0, 2 * np.pi, (2, 1000))
    r = np.sqrt(1 - z * z)
    wi, wo = (mi.Vector3f(r[i] * np.cos(phi[i]), r[i] * np.sin(phi[i]), z[i]) for i in (0, 1))
    si = dr.zeros(mi.SurfaceInteraction3f, 1000)
    si.wi = wi
    theirs = bsdf.eval(mi.BSDFContext(), si, wo)[0].numpy()
    zero, one, alpha = mi.Float(0), mi.Float(1), mi.Float(0.3)
    ours = bottoms.LobeMixture(zero, zero, alpha, one, one, alpha, one).f_pdf(wi, wo)[0] * wo.z
    # Mitsuba's rational fit of Smith's term has the same coefficients; float32 remains.
    np.testing.assert_allclose(ours.numpy(), theirs, rtol=2e-3, atol=1e-6)
