"""Bottoms of the walk: samples follow their densities, and known limits are reached."""

import drjit as dr
import numpy as np
import pytest
from tests.directions import in_plane, pairs_above
from tests.measured import writers

from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.random import stream
from urushi.measured import Merl, tabulated
from urushi.train.distribution import Extended
from urushi.walk import analytic, conductor
from urushi.walk.bottoms import KINDS
from urushi.walk.bottoms.conductor import SchlickConductor
from urushi.walk.bottoms.measured_like import MeasuredLike
from urushi.walk.bottoms.mixture import Mixture
from urushi.walk.table import from_stack

SAMPLES = 1 << 19
#: Bottoms that training does not draw.
METALS = {
    "conductor_compensated": {"alpha": 0.6, "r0": 0.9},
    "conductor_compensated_anisotropic": {"alpha_u": 0.3, "alpha_v": 0.9, "r0": 0.9},
}


def directions(jit, theta):
    """Many copies of wi at an angle to the normal, and uniform numbers from a fixed stream."""
    wi = jit.Array3f(*in_plane([np.degrees(theta)]).T)
    rng = stream(jit.PCG32, dr.arange(jit.UInt64, SAMPLES), 1)
    return wi + dr.zeros(jit.Array3f, SAMPLES), rng


def bottoms(jit, kind):
    """Six bottoms of a kind that training draws, one metal, or one measured table."""
    if kind == "measured":
        return [Merl(tabulated.tabulated(lambda *w: writers.plastic(*w, 0.1), (90, 90, 180)))]
    if kind in METALS:
        columns = from_stack(conductor(**METALS[kind], energy_compensation=True)).bottom
    else:
        columns = Extended(0, kind).sample(np.random.default_rng(3), 6).bottom
    rows = zip(*columns.values(), strict=True)
    return [KINDS[kind].bottom(*(jit.Float(float(x)) for x in row)) for row in rows]


@pytest.mark.parametrize("theta", [0.2, 1.2])
@pytest.mark.parametrize("kind", ["mixture", "measured_like", "measured", *METALS])
def test_samples_follow_their_density_and_integrate_the_brdf(jit, kind, theta):
    """The mean weight is the albedo, and the density integrates to the share that succeeds."""
    for bottom in bottoms(jit, kind):
        wi, rng = directions(jit, theta)
        wo, weight, pdf = bottom.sample(wi, *(rng.next_float32() for _ in range(3)))
        succeeded = (pdf > 0).numpy()
        density = bottom.f_pdf(wi, wo)[1].numpy()
        np.testing.assert_allclose(density[succeeded], pdf.numpy()[succeeded], rtol=1e-3)
        grid = square_to_cosine_hemisphere(jit.Array3f, rng.next_float32(), rng.next_float32())
        f, density = bottom.f_pdf(wi, grid)
        # Four standard errors of either estimate; cosine sampling is the noisier one.
        estimates = [np.atleast_2d(x.numpy()).mean(axis=0) for x in (f * dr.pi, weight)]
        error = 4 * sum(x.std() for x in estimates) / SAMPLES**0.5
        assert abs(estimates[0].mean() - estimates[1].mean()) < error
        values = (density * dr.pi / grid.z).numpy()
        error = 4 * values.std() / SAMPLES**0.5 + 2e-3
        assert abs(values.mean() - succeeded.mean()) < error
        if kind == "measured":  # its lobes, which are fitted, follow the table
            assert estimates[1].std() < 0.5 * estimates[1].mean()


@pytest.mark.parametrize(("eta", "k"), [(0, 1e10), (1e15, 0), (1e300, (1, 1e12, 1e38))])
def test_metals_of_huge_indices_reflect_all_light(eta, k):
    wi, wo = pairs_above(100, 0)
    found, white = (
        analytic.f(conductor(0.1, **fresnel), wi, wo)
        for fresnel in ({"eta": eta, "k": k}, {"r0": 1})
    )
    np.testing.assert_allclose(found, white, rtol=1e-3)  # 4 / (eta cos) at grazing angles


def test_lobes_of_special_exponents_are_those_of_conductors(jit):
    """A mixture of one lobe, or of none; Trowbridge-Reitz's lobe of exponent two is GGX."""
    wi, rng = directions(jit, 0.7)
    wo = square_to_cosine_hemisphere(jit.Array3f, rng.next_float32(), rng.next_float32())
    zero, one, half, r0, two = (jit.Float(x) for x in (0, 1, 0.5, 0.3, 2))
    expected = SchlickConductor(half, r0).f_pdf(wi, wo)[0].numpy()
    lobe, none = (one, half, two, r0, half), (zero, half, half, r0, half)
    for bottom in (
        Mixture(zero, one, half, r0, zero, half, r0),
        MeasuredLike(zero, zero, zero, *lobe, *none),
    ):
        np.testing.assert_allclose(bottom.f_pdf(wi, wo)[0].numpy(), expected, rtol=1e-4)
    diffuse = Mixture(half, zero, half, r0, zero, half, r0).f_pdf(wi, wo)[0]
    np.testing.assert_allclose(diffuse.numpy(), 0.5 / np.pi, rtol=1e-6)


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
