"""What Mitsuba's integrators ask of a BSDF, by every plugin: a case for each of its code paths."""

from typing import NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.directions import above
from tests.mitsuba import sampling
from tests.mitsuba.probes import on_all_sides, spheres, strip, update, vector, walked
from tests.openpbr_surface.probes import WALKS

from urushi.material import encode
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.walk import conductor

MEDIUM = {"int_ior": 1.4, "ext_ior": 1.0, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}
COAT = MEDIUM | {"alpha": 0.2}
WIDTHS = MEDIUM | {"alpha_u": 0.08, "alpha_v": 0.3, "rotation": 40.0}
GGX = {"type": "roughconductor", "distribution": "ggx"}
BRUSHED = GGX | {"alpha_u": 0.1, "alpha_v": 0.4}


def color(*values: float) -> dict:
    return {"type": "rgb", "value": list(values)}


GLASS = {"type": "roughdielectric", "distribution": "ggx", "ext_ior": 1.0, "alpha": 0.2}
BODY = MEDIUM | {"alpha": 0.2, "int_ior": 1.3, "base": GLASS | {"int_ior": 1.5}}
OPENPBR = {"type": "openpbr"}


class Case(NamedTuple):
    """A plugin, and one of its parameters with another value."""

    described: dict
    change: tuple | None = None  # None: no property has the parameters, or it fits for seconds
    across: float | None = None  # index below relative to above; None: it is opaque


#: The light that walks lose is not measured.
CASES = {
    "walks": Case({"type": "layered", **COAT, "base": GGX | {"alpha": 0.3}}, ("sigma_t", 2.5)),
    "walks of two widths": Case({"type": "layered", **WIDTHS, "base": BRUSHED}, ("alpha_v", 0.6)),
    "walks of coloured widths": Case(
        {"type": "layered", "alpha": color(0.05, 0.2, 0.6), "base": BRUSHED}, ("sigma_t", 0.5)
    ),
    "walks into a lower index": Case(
        {"type": "layered", **COAT, "int_ior": 0.8, "base": {"type": "diffuse"}}, ("g", 0.6)
    ),
    "walks into a body": Case({"type": "layered", **BODY}, ("sigma_t", 2.5), 1.5),
    "networks": Case(
        {"type": "neural_layered", **COAT, "base": GGX | {"alpha": 0.3}}, ("alpha", 0.4)
    ),
    "networks of two widths": Case(
        {"type": "neural_layered", **WIDTHS, "base": BRUSHED}, ("rotation", 70.0)
    ),
    "networks over a texture": Case({"type": "neural_layered"}),
    "tables of a body": Case({"type": "neural_layered", **BODY}, ("sigma_t", 2.5), 1.5),
    "saved codes": Case({"type": "neural_brdf"}),
    "measured table": Case({"type": "measured_brdf"}),
    "openpbr": Case(
        OPENPBR | {"base_metalness": 0.4, "specular_roughness_anisotropy": 0.6},
        ("specular_roughness", 0.5),
    ),
    "openpbr under walks": Case(
        OPENPBR | {"base_metalness": 1.0, "coat_weight": 0.7} | WALKS, ("coat_weight", 0.4)
    ),
    "openpbr under networks": Case(
        OPENPBR | {"coat_weight": 0.5, "coat_roughness": 0.4, "fuzz_weight": 0.5}
    ),
    "openpbr pane": Case(
        OPENPBR
        | {"geometry_thin_walled": True, "transmission_weight": 1.0}
        | {"coat_weight": 1.0, "coat_roughness": 0.5, "specular_roughness": 0.4},
        across=1.0,
    ),
}

WHITE = {"alpha": 0.5, "energy_compensation": True, "base": {"type": "diffuse", "reflectance": 1.0}}
LOOK = {"type": "layered", "body": 0.4, "thickness": 1.5, "base": {"type": "diffuse"}}


def blended(sigma_t: float) -> dict:
    """A coat over a blend of a coat and of a metal."""
    inner = {"type": "neural_layered", "sigma_t": sigma_t, "base": GGX | {"alpha": 0.2}}
    blend = {"type": "blendbsdf", "weight": 0.5, "first": inner, "second": GGX | {"alpha": 0.3}}
    return {"type": "neural_layered", "base": blend}


#: Further updates by name: a description, values of parameters, and the description that has them.
UPDATES = {
    **{
        f"{name}, compensated": (
            {"type": name, **WHITE},
            {"alpha.value": 0.8, "eta": 1.7},
            {"type": name, **WHITE, "alpha": 0.8, "int_ior": 1.7, "ext_ior": 1.0},
        )
        for name in ("layered", "neural_layered")
    },
    "an appearance": (LOOK, {"thickness.value": 0.5}, LOOK | {"thickness": 0.5}),
    "a coat in a blend": (blended(0.2), {"bottom.bsdf_0.sigma_t.value": 1.0}, blended(1.0)),
    "a body of glass": (
        {"type": "layered", **BODY},
        {"bottom.eta": 1.7, "bottom.alpha.value": 0.4},
        {"type": "layered", **BODY, "base": GLASS | {"int_ior": 1.7, "alpha": 0.4}},
    ),
}

#: Cases that draw random walks for f: two values of one pair differ.
STOCHASTIC = [name for name in CASES if "walks" in name]

#: One case for each plugin, and for both ways in which `openpbr` has a coat.
EACH = ("walks", "networks", "saved codes", "measured table", "openpbr", "openpbr under walks")

#: Compiling the case of all OpenPBR's parts takes as long as that of all others; those of surfaces
#: that transmit light are in the first tier elsewhere.
LATER = [name for name, case in CASES.items() if case.across] + ["openpbr under networks"]


def plugins_of(first):
    """Parameters of a law of all plugins, of which the first tier has some."""
    rest = [pytest.param(name, marks=pytest.mark.slow) for name in CASES if name not in first]
    return pytest.mark.parametrize("name", [*(name for name in CASES if name in first), *rest])


every_plugin, each_plugin = plugins_of(CASES.keys() - LATER), plugins_of(EACH)


@pytest.fixture(scope="module")
def describe(networks, model, merl_file, tmp_path_factory):
    """The description of a case, with the small networks, a saved material and a measured one."""
    path = tmp_path_factory.mktemp("contract") / "material.safetensors"
    encode(conductor(0.3, (0.9, 0.5, 0.2)), model).save(path)
    extra = {
        "networks": {"weights": str(networks)},
        "saved codes": {"weights": str(networks), "filename": str(path)},
        "measured table": {"filename": str(merl_file)},
    }

    def described(name: str) -> dict:
        if name == "networks over a texture":  # each load needs a bitmap of its own
            extra[name] = {"base": {"type": "diffuse", "reflectance": strip(0.02, 0.9)}}
        return CASES[name].described | extra.get(name, {})

    return described


@pytest.fixture(scope="module")
def plugins():
    """The plugins of cases that were loaded, for laws that change none."""
    return {}


@pytest.fixture
def bsdf(rgb, few_paths, describe, plugins, name):
    """The plugin of a case, which is loaded once for all laws."""
    if name not in plugins:
        plugins[name] = rgb.load_dict(describe(name))
    return plugins[name]


def pairs(name: str, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (N, 3) of all sides from which light comes to a case's plugin, or leaves it."""
    wi, wo = above(count, seed, 0.1), above(count, seed + 1, 0.1)
    return (wi, wo) if CASES[name].across is None else on_all_sides(wi, wo)


@every_plugin
def test_the_density_is_normalised_and_that_of_the_samples(bsdf, name):
    across = CASES[name].across
    angles = (40, 85) if across is None else (40, 85, 110, 160)
    sampling.check(bsdf, angles, len(CASES), across)


@every_plugin
def test_reciprocity(rgb, describe, bsdf, name):
    """Of f over the square of the index on the side of wi. Up to rounding; of walks the means,
    within five standard errors of all pairs. OpenPBR's fuzz is defined by one of the directions."""
    if "fuzz_weight" in CASES[name].described:
        bsdf = rgb.load_dict(describe(name) | {"fuzz_weight": 0.0})
    both, walks = pairs(name, 200, 1), name in STOCHASTIC
    there, back = (
        np.abs(walked(bsdf, wi, wo, 1024 if walks else 1))
        / np.where(wi[:, 2:] > 0, 1, (CASES[name].across or 1) ** 2)
        for wi, wo in (both, both[::-1])
    )
    if not walks:
        np.testing.assert_allclose(there, back, rtol=1e-4, atol=1e-6)
        return
    there, back = there.mean(axis=2), back.mean(axis=2)  # channels share random numbers
    error = np.sqrt((there.var(axis=0) + back.var(axis=0)) / len(there))
    assert (np.abs(there.mean(axis=0) - back.mean(axis=0)) < 5 * error + 1e-6).all()


@every_plugin
def test_no_direction_reflects_more_than_arrives(rgb, bsdf, name):
    """The mean weight of samples, which is f cos / pdf of eval and pdf where f is no walk's. Those
    of importance are shares of power, also where light crosses into another index."""
    count, two_sided = 1 << 14, CASES[name].across is not None
    context = rgb.BSDFContext(rgb.TransportMode.Importance) if two_sided else rgb.BSDFContext()
    u = np.random.default_rng(3).random((3, count), np.float32)
    for cosine in (1.0, 0.5, 0.1, *((-0.8, -0.2) if two_sided else ())):
        wi = np.tile(np.float32([(1 - cosine**2) ** 0.5, 0, cosine]), (count, 1))
        si = probing.interaction(wi, np.full((count, 2), 0.3), np.arange(count))
        sample, weight = bsdf.sample(context, si, rgb.Float(u[0]), rgb.Point2f(u[1:]))
        f_cos, pdf = bsdf.eval_pdf(context, si, sample.wo)
        drawn, light = sample.pdf.numpy() > 0, weight.numpy()
        # The density at a drawn direction depends on the direction's last digits.
        np.testing.assert_allclose(pdf.numpy()[drawn], sample.pdf.numpy()[drawn], rtol=0.02)
        if name not in STOCHASTIC:
            expected = (f_cos / pdf).numpy()
            np.testing.assert_allclose(light[:, drawn], expected[:, drawn], rtol=0.02, atol=1e-6)
        mean, error = light.mean(axis=1), light.std(axis=1) / count**0.5
        assert (light >= 0).all() and (mean <= 1.005 + 5 * error).all()


@pytest.mark.parametrize("name", [name for name, case in CASES.items() if case.across is None])
def test_nothing_passes_below_the_horizon(rgb, bsdf):
    up = above(64, 4, 0.1)
    down = up * np.float32([1, 1, -1])
    for wi, wo in ((up, down), (down, up), (down, down)):
        si = probing.interaction(wi, np.full((64, 2), 0.3))
        f_cos, pdf = bsdf.eval_pdf(rgb.BSDFContext(), si, rgb.Vector3f(wo.T.copy()))
        assert not f_cos.numpy().any() and not pdf.numpy().any()


def values(bsdf, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f cos (N, 3) by `eval_pdf`, each pair with random numbers of its own, in a texel's middle."""
    si = probing.interaction(wi, np.full((len(wi), 2), 0.25), np.arange(len(wi)))
    return bsdf.eval_pdf(mi.BSDFContext(), si, vector(wo))[0].numpy().T


@each_plugin
def test_wrappers_take_their_share(rgb, bsdf, name):
    """Where they are read; the same random numbers give the same walks."""
    black = {"type": "diffuse", "reflectance": 0.0}
    first, second = (strip(*w, filter_type="nearest") for w in ((0.0, 1.0), (1.0, 0.0)))
    wrappers = [
        (1, {"type": "normalmap", "normalmap": strip([0.5, 0.5, 1.0]), "inner": bsdf}),
        (1, {"type": "bumpmap", "map": strip(0.5), "inner": bsdf}),
        *((x, {"type": "mask", "opacity": x, "inner": bsdf}) for x in (1.0, 0.4)),
        (1, {"type": "blendbsdf", "weight": first, "one": bsdf, "two": black}),
        (1, {"type": "blendbsdf", "weight": second, "one": black, "two": bsdf}),
        (0.75, {"type": "blendbsdf", "weight": 0.25, "one": bsdf, "two": black}),
    ]
    (wi, wo), down = pairs(name, 36, 3), np.float32([1, 1, -1])
    expected = values(bsdf, wi, wo)
    for share, described in wrappers:
        found = values(rgb.load_dict(described), wi, wo)
        np.testing.assert_allclose(found, share * expected, 1e-4, 1e-7, err_msg=str(described))
    if CASES[name].across is None:
        both = rgb.load_dict({"type": "twosided", "inner": bsdf})
        for sides in ((wi, wo), (wi * down, wo * down)):
            np.testing.assert_allclose(values(both, *sides), expected, 1e-4, 1e-7)


def xml(type: str, name: str = "", **properties) -> str:
    """A BSDF's dictionary as XML."""
    inner = ""
    for key, value in properties.items():
        if isinstance(value, dict):
            inner += xml(name=key, **value)
        else:
            tag = {bool: "boolean", float: "float", str: "string"}[value.__class__]
            text = str(value).lower() if tag == "boolean" else value
            inner += f'<{tag} name="{key}" value="{text}"/>'
    label = f'name="{name}"' if name else 'version="3.0.0"'
    return f'<bsdf type="{type}" {label}>{inner}</bsdf>'


@pytest.mark.parametrize("name", EACH)
def test_xml_describes_the_same(rgb, describe, bsdf, name):
    read = rgb.load_string(xml(**describe(name)))
    assert str(read) == str(bsdf)
    np.testing.assert_array_equal(*(values(x, *pairs(name, 36, 3)) for x in (read, bsdf)))


@each_plugin
def test_calls_agree(rgb, bsdf, name):
    """`eval`, one lane, and a loop that is recorded give the value of `eval_pdf`."""
    (wi, wo), context = pairs(name, 36, 3), rgb.BSDFContext()
    expected, out = values(bsdf, wi, wo)[:, 0], vector(wo)
    si = probing.interaction(wi, np.full((len(wi), 2), 0.25), np.arange(len(wi)))
    np.testing.assert_allclose(bsdf.eval(context, si, out)[0].numpy(), expected, rtol=1e-5)

    def add(index, total):
        return index + 1, total + bsdf.eval(context, si, out)[0]

    start = rgb.UInt32(0), dr.zeros(rgb.Float, len(wi))
    _, total = dr.while_loop(start, lambda index, total: index < 2, add)
    np.testing.assert_allclose(total.numpy(), 2 * expected, rtol=1e-5)
    for row in (0, len(wi) - 1):
        si = probing.interaction(wi[row : row + 1], np.full((1, 2), 0.25), row)
        single = bsdf.eval(context, si, rgb.Vector3f(wo[row].tolist()))[0].numpy()
        np.testing.assert_allclose(single, expected[row], rtol=1e-4)


def test_a_scene_is_rendered_while_a_plugin_is_loaded(rgb, describe, monkeypatch):
    """Another thread may do so: Mitsuba then evaluates all BSDFs that it knows, here of two
    plugins, one inside the other."""
    scene = rgb.load_dict(spheres({"type": "diffuse"}, size=4))
    read, pictures = CoatTextures.at, []

    def rendering(*args):
        if not pictures:
            pictures.append(rgb.render(scene, spp=1).numpy())
        return read(*args)

    monkeypatch.setattr(CoatTextures, "at", rendering)
    rgb.load_dict(describe("openpbr under walks"))
    np.testing.assert_array_equal(pictures[0], rgb.render(scene, spp=1).numpy())


@pytest.mark.parametrize("name", [*(name for name, case in CASES.items() if case.change), *UPDATES])
def test_an_updated_plugin_is_one_that_is_loaded_so(rgb, describe, name):
    """OpenPBR's tables for any parameter are coarser, by 1 %, than those of a number."""
    if name in UPDATES:
        first, changes, second = UPDATES[name]
    else:
        first, (end, value) = describe(name), CASES[name].change
        changes, second = {f"{end}.value": value}, first | {end: value}
    wi, wo = above(64, 5, 0.1), above(64, 6, 0.1)
    wo[::4, 2] *= -1  # transmitted
    bsdf = rgb.load_dict(first)
    before = walked(bsdf, wi, wo, 1)
    update(bsdf, changes)
    expected = walked(rgb.load_dict(second), wi, wo, 1)
    tolerance = 0.01 if "openpbr" in name else 1e-4
    np.testing.assert_allclose(walked(bsdf, wi, wo, 1), expected, rtol=tolerance, atol=1e-6)
    assert not np.allclose(before, expected, rtol=0.01)


def special_pairs() -> tuple[np.ndarray, np.ndarray]:
    """Pairs at which arguments of roots, logarithms or divisions become zero."""
    a, b = above(200, 7), above(200, 8)
    normal, low = np.tile(np.float32([0, 0, 1]), (200, 1)), a * np.float32([1, 1, 1e-4])
    low /= np.linalg.norm(low, axis=-1, keepdims=True)
    mirror = np.float32([-1, -1, 1])
    pairs = [
        (a, b), (normal, b), (a, normal), (normal, normal), (a, a), (a, a * mirror), (low, b),
        (low, low), (low, low * mirror),
    ]  # fmt: skip
    return tuple(np.concatenate(side) for side in zip(*pairs, strict=True))


@pytest.mark.parametrize("name", [name for name in CASES if name not in (*STOCHASTIC, *LATER)])
def test_derivatives_by_directions_are_finite(rgb, bsdf):
    """Walks have none."""
    wi, wo = special_pairs()
    si = probing.interaction(wi, np.full((len(wi), 2), 0.3))
    ends = rgb.Vector3f(si.wi), vector(wo)
    dr.enable_grad(*ends)
    si.wi = ends[0]
    f, pdf = bsdf.eval_pdf(rgb.BSDFContext(), si, ends[1])
    dr.backward(dr.sum(f.x + f.y + f.z + pdf))
    for end in ends:
        assert np.isfinite(dr.grad(end).numpy()).all()


@each_plugin
def test_every_variant_renders(few_paths, describe, plugins, name):
    """In this order, because a class must not outlive its variant; and two of a kind, which Mitsuba
    must not mix up."""
    plugins.clear()
    for variant in ("llvm_ad_spectral", "llvm_ad_mono", "llvm_ad_rgb"):
        mi.set_variant(variant)
        scene = mi.load_dict(spheres(describe(name), describe(name), size=4))
        picture = mi.render(scene, spp=8).numpy()
        assert np.isfinite(picture).all() and picture.min() > 0
