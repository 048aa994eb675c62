"""`layered` without a nested BSDF is a slab: its f, sampling and flags, from both sides."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import check_walk

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.walk.simulate import albedo

MEDIUM = {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}
PANE, GLASS = {"type": "thindielectric"}, {"type": "roughdielectric", "distribution": "ggx"}
SLABS = {
    "pane": {"alpha": 0.1, "int_ior": 1.5},
    "sharp pane": {"alpha": 0.01, "int_ior": 1.5, "sigma_t": 0.3},
    "thinner": {"alpha": 0.2, "int_ior": 0.7} | MEDIUM,
    "paper": {"alpha": 0.4, "int_ior": 1.4} | MEDIUM,
    "roughest": {"alpha": 1.0, "int_ior": 1.8} | MEDIUM,
    "brushed": {"alpha_u": 0.1, "alpha_v": 0.5, "int_ior": 1.6, "rotation": 30} | MEDIUM,
    "lacquered": {
        "alpha": 0.2,
        "int_ior": 1.5,
        "sigma_t": 0.3,
        "paper": {"type": "layered", "alpha": 0.5, "int_ior": 1.2} | MEDIUM,
    },
    "coloured widths": {
        "alpha": {"type": "rgb", "value": [0.05, 0.2, 0.6]},
        "int_ior": 1.5,
    },
    "on a pane": {"alpha": 0.3, "int_ior": 1.4, "base": PANE | {"int_ior": 1.6}} | MEDIUM,
    "a medium on a pane": {"int_ior": 1.0, "base": PANE | {"int_ior": 1.5}} | MEDIUM,
    "body": {"alpha": 0.1, "int_ior": 1.3, "base": GLASS | {"int_ior": 1.5, "alpha": 0.2}} | MEDIUM,
    "smooth body": {"alpha": 0.01, "int_ior": 1.3, "base": {"type": "dielectric"}},
    "denser coat": {"alpha": 0.3, "int_ior": 1.8, "base": GLASS | {"int_ior": 1.33}} | MEDIUM,
    "matched body": {"alpha": 0.2, "int_ior": 1.5, "base": GLASS | {"int_ior": 1.5}} | MEDIUM,
    "brushed body": {
        "alpha": 0.1,
        "int_ior": 1.4,
        "rotation": 20,
        "base": GLASS | {"int_ior": 1.6, "alpha_u": 0.1, "alpha_v": 0.4},
    },
    "two on a body": {
        "alpha": 0.2,
        "int_ior": 1.5,
        "sigma_t": 0.3,
        "below": {
            "type": "layered",
            "alpha": 0.5,
            "int_ior": 1.2,
            "base": GLASS | {"int_ior": 1.7, "alpha": 0.3},
        }
        | MEDIUM,
    },
}
#: Index below relative to that above, of slabs on a body of glass.
INDICES = {
    "body": 1.5,
    "smooth body": 1.5046,
    "denser coat": 1.33,
    "matched body": 1.5,
    "brushed body": 1.6,
    "two on a body": 1.7,
}
#: Slabs of the first tier.
FIRST = ("sharp pane", "brushed", "body", "two on a body")
#: Angles of wi from the normal [degrees], above and below.
ANGLES = (0, 70, 89, 95, 150)


def load(mi, slab: dict):
    """The slab, and its glass, in a vacuum."""
    glass = {
        key: value | {"ext_ior": 1.0}
        for key, value in slab.items()
        if isinstance(value, dict) and "dielectric" in value["type"]
    }
    return mi.load_dict({"type": "layered", "ext_ior": 1.0} | slab | glass)


PAPER = urushi.slab(0.5, 0.8, **MEDIUM, far=urushi.dielectric(0.5, 1 / 1.2))
DESCRIBED = {
    "paper": urushi.slab(0.4, 1.4, **MEDIUM),
    "lacquered": urushi.coat(PAPER, 0.2, 1.5, sigma_t=0.3),
    "on a pane": urushi.coat(
        urushi.slab(0.01, 1.6 / 1.4, far=urushi.dielectric(0.01, 1 / 1.6)), 0.3, 1.4, **MEDIUM
    ),
    "a medium on a pane": urushi.coat(urushi.slab(0.01, 1.5), 0.1, 1.0, **MEDIUM),
    "body": urushi.slab(0.1, 1.3, **MEDIUM, far=urushi.dielectric(0.2, 1.5 / 1.3)),
    "denser coat": urushi.slab(0.3, 1.8, **MEDIUM, far=urushi.dielectric(0.1, 1.33 / 1.8)),
    "matched body": urushi.slab(0.2, 1.5, **MEDIUM, far=urushi.dielectric(0.1, 1.0)),
}


@pytest.mark.parametrize("name", DESCRIBED)
def test_f_is_that_of_simulate_on_all_sides(rgb, name):
    check_walk(load(rgb, SLABS[name]), DESCRIBED[name], sides=True)


@pytest.mark.parametrize(
    "name",
    [name if name in FIRST else pytest.param(name, marks=pytest.mark.slow) for name in SLABS],
)
def test_samples_follow_the_density_on_the_sphere(rgb, sampling, name):
    bsdf = load(rgb, SLABS[name])
    for seed, degrees in enumerate(ANGLES):
        test = sampling.chi_squared(bsdf, degrees, seed, INDICES.get(name, 1.0))
        assert test.run(0.01, test_count=len(ANGLES) * len(SLABS), quiet=True), test.messages
        assert test.pdf_sum[0] == pytest.approx(1, abs=0.005)  # the quadrature of narrow lobes
        assert test.histogram_sum[0] == 1  # no sample fails


@pytest.mark.parametrize("name", ["paper", "body"])
@pytest.mark.parametrize("degrees", [35, 70, 110, 150])
def test_the_weights_of_samples_add_up_to_the_shares(rgb, name, degrees):
    count, bsdf = 1 << 17, load(rgb, SLABS[name])
    wi = np.array([[np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))]], np.float32)
    si = dr.zeros(rgb.SurfaceInteraction3f, count)
    si.wi = rgb.Vector3f(wi[0])
    rng = rgb.PCG32(size=count)
    si.p = rgb.Point3f(rng.next_float32(), 0, 0)
    u = rgb.Point2f(rng.next_float32(), rng.next_float32())
    context = rgb.BSDFContext(rgb.TransportMode.Importance)
    bs, weight = bsdf.sample(context, si, rng.next_float32(), u)
    through, weight = bs.wo.z.numpy() * wi[0, 2] < 0, weight.numpy()[0]
    flag = rgb.BSDFFlags.GlossyTransmission
    assert np.array_equal((bs.sampled_type.numpy() & int(flag)) != 0, through)
    assert np.array_equal(bs.sampled_component.numpy() == 1, through)
    index = INDICES.get(name, 1.0) ** np.sign(wi[0, 2])
    np.testing.assert_allclose(bs.eta.numpy(), np.where(through, index, 1), rtol=1e-6)
    for transmitted in (False, True):
        expected, se = albedo(DESCRIBED[name], wi, transmitted=transmitted)
        value = np.where(through == transmitted, weight, 0)
        error = np.hypot(value.std() / np.sqrt(count), se[0, 0])
        assert abs(value.mean() - expected[0, 0]) < 5 * error
        assert error < 0.03 * expected[0, 0]


def test_flags_and_refusals(rgb):
    has, flags = rgb.has_flag, rgb.BSDFFlags
    for name, slab in SLABS.items():
        bsdf = load(rgb, slab)
        assert has(bsdf.flags(), flags.Transmission)
        assert has(bsdf.flags(), flags.BackSide)
        assert has(bsdf.flags(), flags.NonSymmetric) == (name in INDICES)
    texture = {"type": "checkerboard", "color0": 1.3, "color1": 1.5}
    clear = {"int_ior": 1.0, "ext_ior": 1.0, "sigma_t": 1.0}
    for change, sentence in (
        (clear, "no interface bends light through this slab"),
        (clear | {"base": {"type": "dielectric", "int_ior": "air"}}, "no interface bends light"),
        ({"int_ior": texture}, "int_ior is a texture, but a slab with air on both sides"),
        ({"base": {"type": "roughdielectric"}}, "has the distribution 'beckmann'; give 'ggx'"),
        ({"base": PANE | {"specular_transmittance": 0.5}}, "has a specular_transmittance"),
        (
            {"base": GLASS | {"int_ior": 1.6, "ext_ior": 1.4}},
            "relative to its ext_ior is 1.1429, fr",
        ),
        (
            {"base": PANE | {"int_ior": 1.8, "ext_ior": 1.33}},
            "'thindielectric' relative to its ext",
        ),
        (
            {"base": {"type": "dielectric", "int_ior": "air", "ext_ior": 1.5}},
            "ext_ior is 0.66685, ",
        ),
        (
            {"int_ior": 3.0, "ext_ior": 1.0, "base": {"type": "dielectric", "int_ior": 0.9}},
            "the index below the slab relative to int_ior is 0.29.*it must be",
        ),
    ):
        with pytest.raises(RuntimeError, match=sentence):
            rgb.load_dict({"type": "layered"} | change)
    for slab in ({"type": "layered"}, {"type": "layered", "base": GLASS}):
        with pytest.raises(RuntimeError, match="without a transmission component"):
            rgb.load_dict({"type": "twosided", "slab": slab})


#: Slabs that `neural_layered` has tables of. Of nested slabs only the parameters count.
TABLES = {
    "pane": {"alpha": 0.02, "int_ior": 1.5},
    **{name: SLABS[name] for name in ("paper", "body", "a medium on a pane", "lacquered")},
}


def test_tables_are_the_walk_on_all_sides(rgb):
    import mitsuba as mi

    mi.set_variant("llvm_ad_spectral")
    wi, wo = cosine_pairs(np.random.default_rng(4), 64)
    wi[::2, 2] *= -1
    wo[::4, 2] *= -1
    wo[1::4, 2] *= -1
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi = mi.Vector3f(wi.T)
    si.wavelengths = mi.Spectrum(450, 500, 550, 600)
    cosine = np.abs(wo[:, 2])
    for name in ("paper", "body"):
        table = mi.load_dict({"type": "neural_layered", "ext_ior": 1.0} | TABLES[name])
        for mode in ("Radiance", "Importance"):
            context = mi.BSDFContext(getattr(mi.TransportMode, mode))
            f = table.eval(context, si, mi.Vector3f(wo.T)).numpy()[0]
            options = {"walks": 1 << 12, "progress": False, "mode": mode.lower()}
            expected, _ = urushi.simulate(DESCRIBED[name], wi, wo, **options)
            error = np.abs(f - expected[:, 0] * cosine)
            assert error.sum() < 0.05 * (expected[:, 0] * cosine).sum()
    mi.set_variant("llvm_ad_rgb")


@pytest.mark.parametrize("name", TABLES)
def test_samples_of_tables_follow_their_density(rgb, sampling, name):
    bsdf = rgb.load_dict({"type": "neural_layered"} | TABLES[name])
    assert rgb.has_flag(bsdf.flags(), rgb.BSDFFlags.Transmission)
    for seed, degrees in enumerate(ANGLES):
        test = sampling.chi_squared(bsdf, degrees, seed, INDICES.get(name, 1.0))
        assert test.run(0.01, test_count=len(ANGLES) * len(TABLES), quiet=True), test.messages
        assert test.histogram_sum[0] == 1  # no sample fails


@pytest.mark.parametrize("sigma_t", [0.0, 0.3])
def test_a_coat_of_the_glass_s_own_index_is_its_surface(rgb, sigma_t):
    """Tables against Mitsuba's plugin, of which a tint attenuates what is inside."""
    glass = GLASS | {"int_ior": 1.5, "alpha": 0.3}
    surface = {"alpha": 0.02, "int_ior": 1.5}
    coated = rgb.load_dict({"type": "neural_layered", "sigma_t": sigma_t, "base": glass, **surface})
    bare = rgb.load_dict(GLASS | surface)
    wi, wo = cosine_pairs(np.random.default_rng(4), 512)
    for lower in (False, True):
        a, b = (w * np.float32([1, 1, -1 if lower else 1]) for w in (wi, wo))
        si = dr.zeros(rgb.SurfaceInteraction3f, len(a))
        si.wi, to = rgb.Vector3f(a.T), rgb.Vector3f(b.T)
        f, expected = (x.eval(rgb.BSDFContext(), si, to).numpy()[0] for x in (coated, bare))
        left = np.exp(-sigma_t * lower * (1 / wi[:, 2] + 1 / wo[:, 2]))
        np.testing.assert_allclose(f, expected * left, rtol=2e-3, atol=1e-5)
    if sigma_t == 0:
        count, rng = 1 << 14, rgb.PCG32(size=1 << 14)
        for degrees in (0, 60, 85, 100, 130, 137, 180):
            direction = np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))
            si = dr.zeros(rgb.SurfaceInteraction3f, count)
            si.wi = rgb.Vector3f([float(x) for x in direction])
            u = rng.next_float32(), rgb.Point2f(rng.next_float32(), rng.next_float32())
            shares = []
            for bsdf in (coated, bare):
                bs, weight = bsdf.sample(rgb.BSDFContext(rgb.TransportMode.Importance), si, *u)
                same = bs.wo.z.numpy() * direction[2] > 0
                shares.append([(weight.numpy()[0] * x).mean() for x in (same, ~same)])
            # 0.006 is the noise of the samples
            np.testing.assert_allclose(*shares, atol=0.012)


def test_tables_follow_changes_and_refuse_what_they_cannot_hold(rgb):
    bsdf = rgb.load_dict({"type": "neural_layered"} | TABLES["pane"])
    held = [*bsdf._reflected, bsdf._passed]
    assert all(dr.type_v(table) == dr.VarType.Float16 for table in held)
    assert 2 * sum(map(len, held)) <= 1e6
    parameters = rgb.traverse(bsdf)
    parameters["sigma_t.value"] = 1.0
    parameters.update()
    changed = rgb.load_dict({"type": "neural_layered", "sigma_t": 1.0} | TABLES["pane"])
    si = dr.zeros(rgb.SurfaceInteraction3f)
    si.wi = rgb.Vector3f(0.6, 0, 0.8)
    f = [b.eval(rgb.BSDFContext(), si, rgb.Vector3f(-0.6, 0, -0.8)) for b in (bsdf, changed)]
    np.testing.assert_array_equal(*f)
    dr.enable_grad(parameters["alpha.value"])
    parameters.set_dirty("alpha.value")
    with pytest.raises(ParameterError, match="neural_layered: a parameter carries gradients, but"):
        parameters.update()
    noise = {"type": "checkerboard"}
    for change, sentence in (
        ({"sigma_t": noise}, "sigma_t is a texture, but the tables of a slab are of constants; us"),
        ({"alpha_u": 0.1, "alpha_v": 0.2}, "for one width of each interface; use the plugin"),
        ({"base": GLASS | {"alpha_u": 0.1, "alpha_v": 0.2}}, "for one width of each interface"),
        ({"base": GLASS | {"alpha": noise}}, "alpha is a texture, but the tables of a slab"),
        ({"int_ior": 1.0, "ext_ior": 1.0}, "no interface bends light through this slab"),
        ({"alpha": 2.0}, "alpha is 2; it must be a GGX width"),
    ):
        with pytest.raises(RuntimeError, match=f"neural_layered: .*{sentence}"):
            rgb.load_dict({"type": "neural_layered"} | change)
    with pytest.raises(RuntimeError, match="without a transmission component"):
        rgb.load_dict({"type": "twosided", "slab": {"type": "neural_layered"}})


def test_tables_have_derivatives_of_the_medium(rgb):
    """Those of f summed over pairs on all sides, against slabs at 0.08 to both sides."""
    bsdf = rgb.load_dict({"type": "neural_layered"} | TABLES["body"])
    parameters = rgb.traverse(bsdf)
    wi, wo = cosine_pairs(np.random.default_rng(4), 256)
    wi[::2, 2] *= -1
    wo[::4, 2] *= -1
    si = dr.zeros(rgb.SurfaceInteraction3f, len(wi))
    si.wi, to = rgb.Vector3f(wi.T), rgb.Vector3f(wo.T)

    def total():
        return dr.sum(bsdf.eval(rgb.BSDFContext(), si, to)[0])

    key, found = "sigma_t.value", []
    number = float(parameters[key][0])
    for end in (number - 0.08, number + 0.08):
        parameters[key] = end
        parameters.update()
        found.append(float(total()[0]))
    parameters[key] = number
    dr.enable_grad(parameters[key])
    parameters.update()
    dr.backward(total())
    slope = float(np.sum(np.array(dr.grad(parameters[key]))))
    assert slope == pytest.approx((found[1] - found[0]) / 0.16, rel=0.05)


@pytest.mark.parametrize("index", ["bk7", 1.6201, "water"])
def test_indices_of_bodies_are_absolute(rgb, index):
    """In a medium of 1.4, which outside and coat are, a body and a bubble of air have the ratio to
    it."""
    numbers = {"bk7": 1.5046, "water": 1.333}
    n = numbers.get(index, index) / 1.4
    body = {"base": {"type": "dielectric", "int_ior": index}}
    bubble = {"base": {"type": "dielectric", "int_ior": "air"}}
    same = {"type": "layered", "int_ior": 1.4, "ext_ior": 1.4}
    for slab, ratio in ((body, n), (bubble, 1.000277 / 1.4)):
        assert float(rgb.load_dict(same | slab)._index.numpy()[0]) == pytest.approx(ratio, 1e-5)


def test_a_body_of_glass_follows_its_parameters(rgb):
    bsdf = load(rgb, SLABS["body"])
    parameters = rgb.traverse(bsdf)
    parameters["bottom.eta"] = 1.7
    parameters["bottom.alpha.value"] = 0.4
    parameters.update()
    changed = {"base": GLASS | {"int_ior": 1.7, "alpha": 0.4}}
    wi, wo = cosine_pairs(np.random.default_rng(5), 64)
    si = dr.zeros(rgb.SurfaceInteraction3f, 64)
    si.wi, down = rgb.Vector3f(wi.T), rgb.Vector3f((wo * [1, 1, -1]).T)
    f = [b.eval(rgb.BSDFContext(), si, down) for b in (bsdf, load(rgb, SLABS["body"] | changed))]
    np.testing.assert_allclose(*f, rtol=1e-4)


def test_the_coat_of_a_body_may_have_a_textured_index(rgb):
    halves = {"type": "checkerboard", "color0": 1.3, "color1": 1.8}
    textured = load(rgb, SLABS["body"] | {"int_ior": halves})
    wi, wo = cosine_pairs(np.random.default_rng(5), 64)
    si = dr.zeros(rgb.SurfaceInteraction3f, 64)
    si.wi, down = rgb.Vector3f(wi.T), rgb.Vector3f((wo * [1, 1, -1]).T)
    for u, index in ((0.6, 1.3), (0.1, 1.8)):
        si.uv = rgb.Point2f(dr.full(rgb.Float, u, 64), 0.1)
        constant = load(rgb, SLABS["body"] | {"int_ior": index})
        f = [bsdf.eval(rgb.BSDFContext(), si, down) for bsdf in (textured, constant)]
        np.testing.assert_allclose(*f, rtol=1e-4)


def test_balls_of_coated_glass_are_lossless_and_hold_media(rgb):
    """Under a constant sky, a smooth film of the glass's own index changes nothing."""

    def picture(bsdf, **medium):
        film = {"type": "hdrfilm", "width": 16, "height": 16, "rfilter": {"type": "box"}}
        view = rgb.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
        scene = {
            "type": "scene",
            "integrator": {"type": "volpath", "max_depth": 64, "rr_depth": 5},
            "sensor": {"type": "perspective", "fov": 20, "to_world": view, "film": film},
            "sky": {"type": "constant"},
            "ball": {"type": "sphere", "bsdf": bsdf} | medium,
        }
        return np.array(rgb.render(rgb.load_dict(scene), spp=256, seed=2)).mean()

    glass = {"type": "dielectric", "int_ior": 1.5}
    coated = {"type": "layered", "alpha": 0.01, "int_ior": 1.5, "base": glass}
    # Radiance grows by the square of the index inside, and returns to that of the sky.
    assert picture(coated) == pytest.approx(1, abs=0.02)
    medium = {"interior": {"type": "homogeneous", "sigma_t": 0.7, "albedo": 0.3}}
    bare = picture(glass, **medium)
    assert bare < 0.6
    assert picture(coated, **medium) == pytest.approx(bare, rel=0.04)


def test_a_context_asks_for_one_component(rgb):
    """As Mitsuba's rough glass does, by the kind of light or by the number of the component."""
    slab, si = rgb.load_dict({"type": "layered", "alpha": 0.3}), dr.zeros(rgb.SurfaceInteraction3f)
    si.wi = [0.6, 0, 0.8]
    sides, flags = [rgb.Vector3f(-0.6, 0, z) for z in (0.8, -0.8)], rgb.BSDFFlags

    def seen(kind=None, component=None):
        context = rgb.BSDFContext()
        context.type_mask = context.type_mask if kind is None else +kind
        context.component = context.component if component is None else component
        found = [slab.eval_pdf(context, si, wo) for wo in sides]
        assert [float(f[0][0] > 0) for f, _ in found] == [float(pdf[0] > 0) for _, pdf in found]
        return [bool(pdf[0] > 0) for _, pdf in found]

    assert seen() == [True, True]
    assert seen(flags.GlossyReflection) == seen(component=0) == [True, False]
    assert seen(flags.GlossyTransmission) == seen(component=1) == [False, True]
    assert seen(flags.Null) == [False, False]
