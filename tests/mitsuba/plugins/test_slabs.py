"""`layered` without a nested BSDF is a slab: its f, sampling and flags, from both sides."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.directions import in_plane
from tests.mitsuba import sampling
from tests.mitsuba.probes import check_walk, f, on_all_sides, spheres, strip, vector

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.walk.simulate import albedo

MEDIUM = {"albedo": 0.9, "sigma_t": 1.0, "g": 0.3}
PANE, GLASS = {"type": "thindielectric"}, {"type": "roughdielectric", "distribution": "ggx"}
VARNISH = {"alpha": 0.2, "int_ior": 1.5, "sigma_t": 0.3}
SLABS = {
    "pane": {"alpha": 0.1, "int_ior": 1.5},
    "sharp pane": {"alpha": 0.01, "int_ior": 1.5, "sigma_t": 0.3},
    "thinner": {"alpha": 0.2, "int_ior": 0.7} | MEDIUM,
    "paper": {"alpha": 0.4, "int_ior": 1.4} | MEDIUM,
    "roughest": {"alpha": 1.0, "int_ior": 1.8} | MEDIUM,
    "brushed": {"alpha_u": 0.1, "alpha_v": 0.5, "int_ior": 1.6, "rotation": 30} | MEDIUM,
    "lacquered": VARNISH | {"paper": {"type": "layered", "alpha": 0.5, "int_ior": 1.2} | MEDIUM},
    "coloured widths": {"alpha": {"type": "rgb", "value": [0.05, 0.2, 0.6]}, "int_ior": 1.5},
    "on a pane": {"alpha": 0.3, "int_ior": 1.4, "base": PANE | {"int_ior": 1.6}} | MEDIUM,
    "a medium on a pane": {"int_ior": 1.0, "base": PANE | {"int_ior": 1.5}} | MEDIUM,
    "body": {"alpha": 0.1, "int_ior": 1.3, "base": GLASS | {"int_ior": 1.5, "alpha": 0.2}} | MEDIUM,
    "smooth body": {"alpha": 0.01, "int_ior": 1.3, "base": {"type": "dielectric"}},
    "denser coat": {"alpha": 0.3, "int_ior": 1.8, "base": GLASS | {"int_ior": 1.33}} | MEDIUM,
    "matched body": {"alpha": 0.2, "int_ior": 1.5, "base": GLASS | {"int_ior": 1.5}} | MEDIUM,
    "brushed body": {"alpha": 0.1, "int_ior": 1.4, "rotation": 20}
    | {"base": GLASS | {"int_ior": 1.6, "alpha_u": 0.1, "alpha_v": 0.4}},
    "two on a body": VARNISH
    | {
        "below": {"type": "layered", "alpha": 0.5, "int_ior": 1.2, **MEDIUM}
        | {"base": GLASS | {"int_ior": 1.7, "alpha": 0.3}}
    },
}
#: Index below relative to that above, of slabs on a body of glass.
INDICES = {"body": 1.5, "smooth body": 1.5046, "denser coat": 1.33, "matched body": 1.5}
INDICES |= {"brushed body": 1.6, "two on a body": 1.7}
#: Slabs of which `neural_layered` has tables.
TABLES = ("pane", "paper", "body", "a medium on a pane", "lacquered")
#: Angles of wi from the normal [degrees], above and below.
ANGLES = (0, 70, 89, 95, 150)


def load(mi, slab: dict, plugin: str = "layered"):
    """The slab, and its glass, in a vacuum."""
    glass = {
        key: value | {"ext_ior": 1.0}
        for key, value in slab.items()
        if isinstance(value, dict) and "dielectric" in value["type"]
    }
    return mi.load_dict({"type": plugin, "ext_ior": 1.0} | slab | glass)


def all_sides(count: int):
    """Interactions and directions of pairs, of which as many pass as are reflected."""
    wi, wo = on_all_sides(*cosine_pairs(np.random.default_rng(4), count))
    return probing.interaction(wi, np.zeros((count, 2))), vector(wo)


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
    ("plugin", "name"),
    [*(("layered", x) for x in SLABS), *(("neural_layered", x) for x in TABLES)],
)
def test_samples_follow_the_density_on_the_sphere(rgb, plugin, name):
    bsdf, has, flags = load(rgb, SLABS[name], plugin), rgb.has_flag, rgb.BSDFFlags
    assert has(bsdf.flags(), flags.Transmission) and has(bsdf.flags(), flags.BackSide)
    assert has(bsdf.flags(), flags.NonSymmetric) == (name in INDICES)
    sampling.check(bsdf, ANGLES, len(SLABS), INDICES.get(name, 1.0))


@pytest.mark.parametrize("name", ["paper", "body"])
@pytest.mark.parametrize("degrees", [35, 70, 110, 150])
def test_the_weights_of_samples_add_up_to_the_shares(rgb, name, degrees):
    count, bsdf = 1 << 17, load(rgb, SLABS[name])
    wi, rng = in_plane([degrees]), rgb.PCG32(size=count)
    si = probing.interaction(np.tile(wi, (count, 1)), np.zeros((count, 2)), np.arange(count))
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


CLEAR = {"int_ior": 1.0, "ext_ior": 1.0, "sigma_t": 1.0}
NOISE = {"type": "checkerboard"}
SMOOTH = {"type": "dielectric", "int_ior": "air"}
REFUSALS = {
    "layered": [
        (CLEAR, "no interface bends light through this slab"),
        (CLEAR | {"base": SMOOTH}, "no interface bends light"),
        (
            {"int_ior": NOISE | {"color0": 1.3, "color1": 1.5}},
            "int_ior is a texture, but a slab with air on both sides",
        ),
        ({"base": {"type": "roughdielectric"}}, "has the distribution 'beckmann'; give 'ggx'"),
        ({"base": PANE | {"specular_transmittance": 0.5}}, "has a specular_transmittance"),
        ({"base": GLASS | {"int_ior": 1.6, "ext_ior": 1.4}}, "to its ext_ior is 1.1429, fr"),
        ({"base": PANE | {"int_ior": 1.8, "ext_ior": 1.33}}, "'thindielectric' relative to its"),
        ({"base": SMOOTH | {"ext_ior": 1.5}}, "ext_ior is 0.66685, "),
        (
            {"int_ior": 3.0, "ext_ior": 1.0, "base": SMOOTH | {"int_ior": 0.9}},
            "the index below the slab relative to int_ior is 0.29.*it must be",
        ),
    ],
    "neural_layered": [
        (CLEAR, "no interface bends light through this slab"),
        ({"alpha_u": 0.1, "alpha_v": 0.2}, "for one width of each interface; use the plugin"),
        ({"base": GLASS | {"alpha_u": 0.1, "alpha_v": 0.2}}, "for one width of each interface"),
        (
            {"int_ior": NOISE | {"color0": 1.3, "color1": 1.5}, "base": GLASS | {"int_ior": 1.6}},
            "an index of refraction varies, but tables of a slab are of constant ones; use the",
        ),
        ({"alpha": 2.0}, "alpha is 2; it must be a GGX width"),
    ],
}


@pytest.mark.parametrize("plugin", REFUSALS)
def test_refusals(rgb, plugin):
    for change, sentence in REFUSALS[plugin]:
        with pytest.raises(RuntimeError, match=f"{plugin}: .*{sentence}"):
            rgb.load_dict({"type": plugin} | change)
    for slab in ({"type": plugin}, {"type": plugin, "base": GLASS}):
        with pytest.raises(RuntimeError, match="without a transmission component"):
            rgb.load_dict({"type": "twosided", "slab": slab})


def test_tables_are_the_walk_on_all_sides(spectral):
    si, to = all_sides(64)
    wi, wo = si.wi.numpy().T, to.numpy().T
    cosine = np.abs(wo[:, 2])
    for name in ("paper", "body"):
        table = load(mi, SLABS[name], "neural_layered")
        for mode in ("Radiance", "Importance"):
            context = mi.BSDFContext(getattr(mi.TransportMode, mode))
            f = table.eval(context, si, to).numpy()[0]
            options = {"walks": 1 << 12, "progress": False, "mode": mode.lower()}
            expected, _ = urushi.simulate(DESCRIBED[name], wi, wo, **options)
            error = np.abs(f - expected[:, 0] * cosine)
            assert error.sum() < 0.05 * (expected[:, 0] * cosine).sum()


@pytest.mark.parametrize("sigma_t", [0.0, 0.3])
def test_a_coat_of_the_glass_s_own_index_is_its_surface(rgb, sigma_t):
    """Tables against Mitsuba's plugin, of which a tint attenuates what is inside."""
    glass = GLASS | {"int_ior": 1.5, "alpha": 0.3}
    surface = {"alpha": 0.02, "int_ior": 1.5}
    coated = rgb.load_dict({"type": "neural_layered", "sigma_t": sigma_t, "base": glass, **surface})
    bare = rgb.load_dict(GLASS | surface)
    wi, wo = cosine_pairs(np.random.default_rng(4), 512)
    for lower in (False, True):
        pair = [w * np.float32([1, 1, -1 if lower else 1]) for w in (wi, wo)]
        found, expected = (f(bsdf, *pair) for bsdf in (coated, bare))
        left = np.exp(-sigma_t * lower * (1 / wi[:, 2:] + 1 / wo[:, 2:]))
        np.testing.assert_allclose(found, expected * left, rtol=2e-3, atol=1e-5)


#: Slabs, and the values of their textures at two texels; of single textures near the ends of the
#: range.
TEXTURED = {
    "depth": (SLABS["paper"], {"sigma_t": (0.0, 6.0)}),
    "colour": (SLABS["paper"], {"albedo": ((0.05, 0.5, 0.99), (0.9, 0.1, 0.6))}),
    "width": (SLABS["paper"], {"alpha": (0.02, 0.8)}),
    "asymmetry": (SLABS["a medium on a pane"], {"g": (-0.8, 0.8)}),
    "two on a body": (SLABS["body"], {"sigma_t": ((0.5, 1, 2), (2, 1, 0.5)), "alpha": (0.2, 0.4)}),
    "glass": (SLABS["body"], {"base": GLASS | {"int_ior": 1.5, "alpha": (0.05, 0.5)}}),
}


def at_share(values, share: float):
    """A slab's properties between those of two texels, as constants."""
    if isinstance(values, dict):
        return {k: at_share(x, share) for k, x in values.items()}
    if not isinstance(values, tuple):
        return values
    low, high = (np.array(x, float) for x in values)
    value = low + (high - low) * share
    return {"type": "rgb", "value": value.tolist()} if value.ndim else float(value)


def with_textures(values):
    if isinstance(values, dict):
        return {k: with_textures(x) for k, x in values.items()}
    return strip(*values) if isinstance(values, tuple) else values


@pytest.mark.parametrize("name", TEXTURED)
def test_a_textured_slab_is_a_constant_one_everywhere(rgb, few_paths, name):
    """Also between texels, and on both sides, where it is the slab of the mean parameter."""
    slab, values = TEXTURED[name]
    textured = load(rgb, slab | with_textures(values), "neural_layered")
    si, to = all_sides(512)
    crosses = si.wi.z.numpy() * to.z.numpy() < 0
    for share in (0.0, 0.6):
        constant = load(rgb, slab | at_share(values, share), "neural_layered")
        si.uv = rgb.Point2f(0.25 + 0.5 * share, 0.5)
        found, expected = (
            bsdf.eval(rgb.BSDFContext(), si, to).numpy() for bsdf in (textured, constant)
        )
        for lanes in (crosses, ~crosses):
            error = np.abs(found - expected)[:, lanes].sum()
            assert error < 0.01 * expected[:, lanes].sum()


def test_a_spectral_slab_has_the_medium_of_each_wavelength(spectral, few_paths):
    """Against walks, whose noise is about 2 %."""
    colours = {"albedo": [0.2, 0.5, 0.95], "sigma_t": [0.4, 1.0, 3.0]}
    given = {k: {"type": "rgb", "value": x} for k, x in colours.items()}
    bsdf = load(mi, SLABS["paper"] | given, "neural_layered")
    si, to = all_sides(64)
    si.wavelengths = mi.Spectrum(440, 520, 580, 640)
    assert len(bsdf._layers.axes) == 1  # of wavelengths, however many parameters are coloured
    medium = {k: [x.numpy()[0] for x in bsdf.coats[0].at(si)[k]][:3] for k in colours}
    assert np.ptp(medium["sigma_t"]) > 1
    described = urushi.slab(0.4, 1.4, **MEDIUM | medium)
    wi, wo = si.wi.numpy().T, to.numpy().T
    expected, _ = urushi.simulate(described, wi, wo, walks=1 << 12, progress=False)
    expected *= np.abs(wo[:, 2:])
    found = bsdf.eval(mi.BSDFContext(), si, to).numpy().T[:, :3]
    assert (np.abs(found - expected).sum(axis=0) < 0.05 * expected.sum(axis=0)).all()


def test_a_spectral_slab_follows_its_colours(spectral, few_paths):
    slab = SLABS["pane"] | {"sigma_t": {"type": "rgb", "value": [0.4, 1.0, 3.0]}}
    brighter = slab | {"sigma_t": {"type": "rgb", "value": [0.4, 1.05, 3.0]}}
    bsdf, loaded = (load(mi, x, "neural_layered") for x in (slab, brighter))
    parameters = mi.traverse(bsdf)
    key = "sigma_t.values"
    parameters[key] = mi.traverse(loaded)[key]
    parameters.update()
    si, to = all_sides(64)
    si.wavelengths = mi.Spectrum(440, 520, 580, 640)
    context = mi.BSDFContext()
    np.testing.assert_array_equal(bsdf.eval(context, si, to), loaded.eval(context, si, to))


def test_samples_of_a_textured_slab_follow_the_density(rgb, few_paths):
    slab, values = TEXTURED["width"]
    sampling.check(load(rgb, slab | with_textures(values), "neural_layered"), ANGLES, 1, 1.0)


def test_tables_stay_while_textures_are_within_their_ranges(rgb, few_paths):
    bsdf = load(rgb, SLABS["pane"] | {"sigma_t": strip(0.1, 2.0)}, "neural_layered")
    parameters, before = rgb.traverse(bsdf), bsdf._numbers
    parameters["sigma_t.data"] = 0.5 + 0.5 * parameters["sigma_t.data"]
    parameters.update()
    assert bsdf._numbers is before
    parameters["sigma_t.data"] = 3 * parameters["sigma_t.data"]
    parameters.update()
    assert bsdf._numbers is not before


def test_tables_are_small_and_refuse_gradients_by_indices(rgb):
    bsdf = load(rgb, SLABS["pane"], "neural_layered")
    assert all(dr.type_v(table) == dr.VarType.Float16 for table in bsdf._tables)
    assert 2 * sum(map(len, bsdf._tables)) <= 1e6
    parameters = rgb.traverse(bsdf)
    dr.enable_grad(parameters["eta"])
    parameters.set_dirty("eta")
    with pytest.raises(ParameterError, match="neural_layered: an index of refraction varies, but"):
        parameters.update()


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


def test_the_coat_of_a_body_may_have_a_textured_index(rgb):
    halves = {"type": "checkerboard", "color0": 1.3, "color1": 1.8}
    textured = load(rgb, SLABS["body"] | {"int_ior": halves})
    wi, wo = cosine_pairs(np.random.default_rng(5), 64)
    wo[:, 2] *= -1
    for u, index in ((0.6, 1.3), (0.1, 1.8)):
        constant = load(rgb, SLABS["body"] | {"int_ior": index})
        np.testing.assert_allclose(
            *(f(bsdf, wi, wo, (u, 0.1)) for bsdf in (textured, constant)), rtol=1e-4
        )


def test_balls_of_coated_glass_are_lossless_and_hold_media(rgb):
    """Under a constant sky, a smooth film of the glass's own index changes nothing."""

    def picture(bsdf, **medium):
        scene = spheres(bsdf, integrator="volpath", depth=64, sky={"type": "constant"})
        scene["sphere0"] |= medium
        scene["sensor"] |= {"fov": 20}  # the ball alone
        del scene["lamp"]
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
