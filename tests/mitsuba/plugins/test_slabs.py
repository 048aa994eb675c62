"""`layered` without a nested BSDF is a slab: its f, sampling and flags, from both sides."""

import numpy as np
import pytest

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.walk.simulate import albedo

MEDIUM = {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}
SLABS = {
    "pane": {"alpha": 0.1, "int_ior": 1.5},
    "paper": {"alpha": 0.4, "int_ior": 1.4} | MEDIUM,
    "brushed": {"alpha_u": 0.1, "alpha_v": 0.5, "int_ior": 1.6, "rotation": 30} | MEDIUM,
    "lacquered": {
        "alpha": 0.2,
        "int_ior": 1.5,
        "sigma_t": 0.3,
        "paper": {"type": "layered", "alpha": 0.5, "int_ior": 1.2} | MEDIUM,
    },
}
#: Angles of wi from the normal [degrees], above and below.
ANGLES = (0, 35, 70, 110, 150, 175)


def load(mi, slab: dict):
    """The slab, and those it holds, with no air outside."""
    nested = {k: {**v, "ext_ior": 1.0} if isinstance(v, dict) else v for k, v in slab.items()}
    return mi.load_dict({"type": "layered", "ext_ior": 1.0} | nested)


DESCRIBED = {
    "paper": urushi.slab(0.4, 1.4, **MEDIUM),
    "lacquered": urushi.coat(
        urushi.slab(0.5, 1.2, **MEDIUM, far=urushi.dielectric(0.5, 1 / 1.8)), 0.2, 1.5, sigma_t=0.3
    ),
}


@pytest.mark.parametrize("name", DESCRIBED)
def test_f_is_that_of_simulate_on_all_sides(rgb, name):
    import drjit as dr

    wi, wo = (w.astype(np.float32) for w in cosine_pairs(np.random.default_rng(4), 16))
    wi[::2, 2] *= -1
    wo[::4, 2] *= -1
    wo[1::4, 2] *= -1
    expected, se = urushi.simulate(DESCRIBED[name], wi, wo, walks=1 << 13, progress=False)
    bsdf, count = load(rgb, SLABS[name]), 1 << 12
    si = dr.zeros(rgb.SurfaceInteraction3f, len(wi) * count)
    lane = dr.arange(rgb.UInt32, len(wi) * count)
    si.p = rgb.Point3f(rgb.Float(lane % count), 0, 0)  # walks differ by place
    si.wi, to = (rgb.Vector3f(np.repeat(w, count, axis=0).T) for w in (wi, wo))
    for mode in (rgb.TransportMode.Radiance, rgb.TransportMode.Importance):
        value = bsdf.eval(rgb.BSDFContext(mode), si, to).numpy()[0].reshape(len(wi), count)
        mean, error = value.mean(1), value.std(1) / np.sqrt(count)
        cosine = np.abs(wo[:, 2])
        z = (mean - expected[:, 0] * cosine) / np.hypot(error, se[:, 0] * cosine)
        assert np.abs(z).max() < 5


@pytest.mark.parametrize("slab", SLABS.values(), ids=SLABS.keys())
def test_samples_follow_the_density_on_the_sphere(rgb, slab):
    import drjit as dr
    from mitsuba.python.chi2 import ChiSquareTest, SphericalDomain

    bsdf, context = load(rgb, slab), rgb.BSDFContext()
    for degrees in ANGLES:
        theta = rgb.Float(np.radians(degrees))
        dr.make_opaque(theta)

        def interaction(count, theta=theta):
            si = dr.zeros(rgb.SurfaceInteraction3f, count)
            si.wi = rgb.Vector3f(dr.sin(theta), 0, dr.cos(theta))
            return si

        def sample(u, interaction=interaction):
            si = interaction(dr.width(u))
            bs, _ = bsdf.sample(context, si, u[0], rgb.Point2f(u[1], u[2]))
            return bs.wo, dr.select(bs.pdf > 0, rgb.Float(1), 0)

        def pdf(wo, interaction=interaction):
            return bsdf.pdf(context, interaction(dr.width(wo)), wo)

        test = ChiSquareTest(
            SphericalDomain(), sample, pdf, sample_dim=3, sample_count=1 << 17, res=61, ires=16
        )
        assert test.run(0.01, test_count=len(ANGLES) * len(SLABS), quiet=True), test.messages
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.01)
        assert test.histogram_sum[0] == 1  # no sample fails


@pytest.mark.parametrize("degrees", ANGLES[1:-1])
def test_the_weights_of_samples_add_up_to_the_shares(rgb, degrees):
    import drjit as dr

    count, bsdf = 1 << 17, load(rgb, SLABS["paper"])
    wi = np.array([[np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))]], np.float32)
    si = dr.zeros(rgb.SurfaceInteraction3f, count)
    si.wi = rgb.Vector3f(wi[0])
    rng = rgb.PCG32(size=count)
    si.p = rgb.Point3f(rng.next_float32(), 0, 0)
    u = rgb.Point2f(rng.next_float32(), rng.next_float32())
    bs, weight = bsdf.sample(rgb.BSDFContext(), si, rng.next_float32(), u)
    through, weight = bs.wo.z.numpy() * wi[0, 2] < 0, weight.numpy()[0]
    flag = rgb.BSDFFlags.GlossyTransmission
    assert np.array_equal((bs.sampled_type.numpy() & int(flag)) != 0, through)
    assert np.array_equal(bs.sampled_component.numpy() == 1, through)
    for transmitted in (False, True):
        expected, se = albedo(DESCRIBED["paper"], wi, transmitted=transmitted)
        value = np.where(through == transmitted, weight, 0)
        error = np.hypot(value.std() / np.sqrt(count), se[0, 0])
        assert abs(value.mean() - expected[0, 0]) < 5 * error
        assert error < 0.01 * expected[0, 0]


def test_flags_and_refusals(rgb):
    bsdf = load(rgb, SLABS["paper"])
    assert rgb.has_flag(bsdf.flags(), rgb.BSDFFlags.Transmission)
    assert rgb.has_flag(bsdf.flags(), rgb.BSDFFlags.BackSide)
    with pytest.raises(RuntimeError, match="without a transmission component"):
        rgb.load_dict({"type": "twosided", "slab": {"type": "layered"}})
    with pytest.raises(RuntimeError, match="no interface bends light through this slab"):
        rgb.load_dict({"type": "layered", "int_ior": 1.0, "ext_ior": 1.0, "sigma_t": 1.0})
    texture = {"type": "checkerboard", "color0": 1.3, "color1": 1.5}
    with pytest.raises(RuntimeError, match="int_ior is a texture, but a slab"):
        rgb.load_dict({"type": "layered", "int_ior": texture})
    with pytest.raises(RuntimeError, match="the nested BSDF transmits light; a coat needs"):
        rgb.load_dict({"type": "neural_layered", "below": {"type": "layered"}})
