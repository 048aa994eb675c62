"""Bottoms of the walk: samples follow their densities, and known limits are reached."""

import drjit as dr
import numpy as np
import pytest
from tests.directions import pairs_above

from urushi.core import microfacet
from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.random import stream
from urushi.train.distribution import Extended
from urushi.walk import monte_carlo
from urushi.walk.bottoms import KINDS
from urushi.walk.bottoms.conductor import SchlickConductor
from urushi.walk.bottoms.measured_like import MeasuredLike
from urushi.walk.bottoms.mixture import Mixture

SAMPLES = 1 << 20


@pytest.fixture(scope="module")
def types():
    return monte_carlo.backend()


def directions(types, theta):
    """Many copies of wi at an angle to the normal, and uniform numbers from a fixed stream."""
    wi = types.Array3f(float(np.sin(theta)), 0, float(np.cos(theta)))
    rng = stream(types.PCG32, dr.arange(types.UInt64, SAMPLES), 1)
    return wi + dr.zeros(types.Array3f, SAMPLES), rng


def drawn(types, kind, count):
    table = Extended(0, kind).sample(np.random.default_rng(3), count)
    for row in range(count):
        yield KINDS[kind].bottom(*(types.Float(float(v[row])) for v in table.bottom.values()))


@pytest.mark.parametrize("theta", [0.2, 1.2])
@pytest.mark.parametrize("kind", ["mixture", "measured_like"])
def test_mixture_weights_integrate_the_brdf_and_its_density(types, kind, theta):
    """The mean weight is the albedo, and the density integrates to the share that succeeds."""
    for mixture in drawn(types, kind, 6):
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
    lobe = Mixture(zero, one, half, r0, zero, half, r0).f_pdf(wi, wo)[0]
    conductor = SchlickConductor(half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(lobe.numpy(), conductor.numpy(), rtol=1e-5)
    diffuse = Mixture(half, zero, half, r0, zero, half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(diffuse.numpy(), 0.5 / np.pi, rtol=1e-6)


def test_trowbridge_reitz_lobe_of_exponent_two_is_ggx(types):
    wi, rng = directions(types, 0.7)
    wo = square_to_cosine_hemisphere(types.Array3f, rng.next_float32(), rng.next_float32())
    zero, half, r0 = types.Float(0), types.Float(0.5), types.Float(0.3)
    lobe, none = (types.Float(1), half, types.Float(2), r0, half), (zero, half, half, r0, half)
    f = MeasuredLike(zero, zero, zero, *lobe, *none).f_pdf(wi, wo)[0]
    conductor = SchlickConductor(half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(f.numpy(), conductor.numpy(), rtol=1e-4)


@pytest.mark.parametrize("gamma", [0.6, 1.03, 3.0, 8.0])
@pytest.mark.parametrize("alpha", [0.02, 0.5])
def test_trowbridge_reitz_normals_are_drawn_with_their_density(types, alpha, gamma):
    """Samples and quadrature over theta have one mean of cos^2, and the density integrates to 1."""
    rng = stream(types.PCG32, dr.arange(types.UInt64, SAMPLES), 1)
    parameters = types.Float(alpha), types.Float(gamma)
    m = microfacet.sample_gtr(types.Array3f, *parameters, rng.next_float32(), rng.next_float32())
    drawn_sin2 = 1 - m.z.numpy().astype(np.float64) ** 2
    # Midpoints in ln tan theta, which resolves every width.
    edges = np.linspace(np.log(alpha * 1e-3), np.log(1e4), 20_001)
    theta = np.arctan(np.exp(0.5 * (edges[1:] + edges[:-1])))
    step = np.diff(np.arctan(np.exp(edges)))
    normal = types.Array3f(*(types.Float(x) for x in (np.sin(theta), 0 * theta, np.cos(theta))))
    density = microfacet.gtr_d(normal, *parameters).numpy() * np.cos(theta)
    weight = 2 * np.pi * density * np.sin(theta) * step
    assert np.sum(weight) == pytest.approx(1, abs=2e-3)  # float32 for gamma close to one
    expected = np.sum(weight * np.sin(theta) ** 2)
    # Five standard errors of the samples' mean.
    assert abs(drawn_sin2.mean() - expected) < 5 * drawn_sin2.std() / SAMPLES**0.5 + 2e-3 * expected


def test_beckmann_lobe_is_mitsubas(variant):
    """Mitsuba's roughconductor without Fresnel is the same Beckmann lobe (r0 = 1)."""
    import mitsuba as mi

    bsdf = mi.load_dict(
        {"type": "roughconductor", "material": "none", "alpha": 0.3, "distribution": "beckmann"}
    )
    wi, wo = (mi.Vector3f(np.ascontiguousarray(w.T)) for w in pairs_above(1000, 5, 0.05))
    si = dr.zeros(mi.SurfaceInteraction3f, 1000)
    si.wi = wi
    theirs = bsdf.eval(mi.BSDFContext(), si, wo)[0].numpy()
    zero, one, alpha = mi.Float(0), mi.Float(1), mi.Float(0.3)
    ours = Mixture(zero, zero, alpha, one, one, alpha, one).f_pdf(wi, wo)[0] * wo.z
    # Mitsuba's rational fit of Smith's term has the same coefficients, so only float32 differs.
    np.testing.assert_allclose(ours.numpy(), theirs, rtol=2e-3, atol=1e-6)
