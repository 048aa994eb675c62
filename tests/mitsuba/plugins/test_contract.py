"""What Mitsuba's integrators ask of a BSDF, by every plugin: a case for each of its code paths."""

import drjit as dr
import mitsuba as mi
import numpy as np
import pytest
from tests.directions import above
from tests.mitsuba.probes import spheres, update, vector, walked

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


#: By name, a description, and one of its parameters with another value. None: no property has the
#: parameters, or an update fits a table for seconds. The light that walks lose is not measured.
CASES = {
    "walks": ({"type": "layered", **COAT, "base": GGX | {"alpha": 0.3}}, ("sigma_t", 2.5)),
    "walks of two widths": (
        {"type": "layered", **WIDTHS, "base": BRUSHED},
        ("alpha_v", 0.6),
    ),
    "walks of coloured widths": (
        {"type": "layered", "alpha": color(0.05, 0.2, 0.6), "base": BRUSHED},
        ("sigma_t", 0.5),
    ),
    "walks into a lower index": (
        {"type": "layered", **COAT, "int_ior": 0.8, "base": {"type": "diffuse"}},
        ("g", 0.6),
    ),
    "networks": ({"type": "neural_layered", **COAT, "base": GGX | {"alpha": 0.3}}, ("alpha", 0.4)),
    "networks of two widths": (
        {"type": "neural_layered", **WIDTHS, "base": BRUSHED},
        ("rotation", 70.0),
    ),
    "saved codes": ({"type": "neural_brdf"}, None),
    "measured table": ({"type": "measured_brdf"}, None),
    "openpbr": (
        {"type": "openpbr", "base_metalness": 0.4, "specular_roughness_anisotropy": 0.6},
        ("specular_roughness", 0.5),
    ),
    "openpbr under walks": (
        {
            "type": "openpbr",
            "base_metalness": 1.0,
            "coat_weight": 0.7,
            "reference": True,
            "energy_compensation": False,
        },
        ("coat_weight", 0.4),
    ),
    "openpbr under networks": (
        {"type": "openpbr", "coat_weight": 0.5, "coat_roughness": 0.4, "fuzz_weight": 0.5},
        None,
    ),
}

WHITE = {"alpha": 0.5, "energy_compensation": True, "base": {"type": "diffuse", "reflectance": 1.0}}
LOOK = {"type": "layered", "body": 0.4, "thickness": 1.5, "base": {"type": "diffuse"}}
BODY = {"type": "layered", **COAT, "int_ior": 1.3}
GLASS = {"type": "roughdielectric", "distribution": "ggx", "ext_ior": 1.0}


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
        BODY | {"base": GLASS | {"int_ior": 1.5, "alpha": 0.2}},
        {"bottom.eta": 1.7, "bottom.alpha.value": 0.4},
        BODY | {"base": GLASS | {"int_ior": 1.7, "alpha": 0.4}},
    ),
    "tables of a slab": (
        {"type": "neural_layered", "alpha": 0.02},
        {"sigma_t.value": 1.0},
        {"type": "neural_layered", "alpha": 0.02, "sigma_t": 1.0},
    ),
}

#: Cases that draw random walks for f: two values of one pair differ.
STOCHASTIC = [name for name in CASES if "walks" in name]

#: One case for each plugin, and for both ways in which `openpbr` has a coat.
EACH = ("walks", "networks", "saved codes", "measured table", "openpbr", "openpbr under walks")

#: Compiling the case of all OpenPBR's parts takes as long as that of all others.
LONGEST = "openpbr under networks"

every_plugin = pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.slow) if name == LONGEST else name for name in CASES],
)


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
    return lambda name: CASES[name][0] | extra.get(name, {})


@pytest.fixture(scope="module")
def plugins():
    """The plugins of cases that were loaded, for laws that change none."""
    return {}


@pytest.fixture
def bsdf(rgb, describe, plugins, name):
    """The plugin of a case, which is loaded once for all laws."""
    if name not in plugins:
        plugins[name] = rgb.load_dict(describe(name))
    return plugins[name]


@every_plugin
def test_the_density_is_normalised_and_that_of_the_samples(bsdf, sampling, name):
    sampling.check(bsdf, (40, 85), len(CASES))


@every_plugin
def test_reciprocity(rgb, describe, bsdf, name):
    """Up to rounding; of walks the means, within five standard errors of all pairs. OpenPBR's fuzz
    is defined by one of the directions."""
    wi, wo = above(200, 1, 0.1), above(200, 2, 0.1)
    if "fuzz_weight" in CASES[name][0]:
        bsdf = rgb.load_dict(describe(name) | {"fuzz_weight": 0.0})
    walks = name in STOCHASTIC
    there, back = (walked(bsdf, *w, 1024 if walks else 1) for w in ((wi, wo), (wo, wi)))
    if not walks:
        np.testing.assert_allclose(there, back, rtol=1e-4, atol=1e-6)
        return
    there, back = there.mean(axis=2), back.mean(axis=2)  # channels share random numbers
    error = np.sqrt((there.var(axis=0) + back.var(axis=0)) / len(there))
    assert (np.abs(there.mean(axis=0) - back.mean(axis=0)) < 5 * error + 1e-6).all()


@every_plugin
def test_no_direction_reflects_more_than_arrives(rgb, bsdf, name):
    """The mean weight of samples, which is f cos / pdf of eval and pdf where f is no walk's."""
    count = 1 << 14
    u = np.random.default_rng(3).random((3, count), np.float32)
    for cosine in (1.0, 0.5, 0.1):
        wi = np.tile(np.float32([(1 - cosine**2) ** 0.5, 0, cosine]), (count, 1))
        si = probing.interaction(wi, np.full((count, 2), 0.3), np.arange(count))
        sample, weight = bsdf.sample(rgb.BSDFContext(), si, rgb.Float(u[0]), rgb.Point2f(u[1:]))
        f_cos, pdf = bsdf.eval_pdf(rgb.BSDFContext(), si, sample.wo)
        drawn, light = sample.pdf.numpy() > 0, weight.numpy()
        # The density at a drawn direction depends on the direction's last digits.
        np.testing.assert_allclose(pdf.numpy()[drawn], sample.pdf.numpy()[drawn], rtol=0.02)
        if name not in STOCHASTIC:
            expected = (f_cos / pdf).numpy()
            np.testing.assert_allclose(light[:, drawn], expected[:, drawn], rtol=0.02, atol=1e-6)
        mean, error = light.mean(axis=1), light.std(axis=1) / count**0.5
        assert (light >= 0).all() and (mean <= 1.005 + 5 * error).all()


@every_plugin
def test_nothing_passes_below_the_horizon(rgb, bsdf):
    up = above(64, 4, 0.1)
    down = up * np.float32([1, 1, -1])
    for wi, wo in ((up, down), (down, up), (down, down)):
        si = probing.interaction(wi, np.full((64, 2), 0.3))
        f_cos, pdf = bsdf.eval_pdf(rgb.BSDFContext(), si, rgb.Vector3f(wo.T.copy()))
        assert not f_cos.numpy().any() and not pdf.numpy().any()


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


@pytest.mark.parametrize(
    "name", [*(name for name, (_, change) in CASES.items() if change), *UPDATES]
)
def test_an_updated_plugin_is_one_that_is_loaded_so(rgb, describe, name):
    """OpenPBR's tables for any parameter are coarser, by 1 %, than those of a number."""
    if name in UPDATES:
        first, changes, second = UPDATES[name]
    else:
        first, (end, value) = describe(name), CASES[name][1]
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


@pytest.mark.parametrize("name", [name for name in CASES if name not in (*STOCHASTIC, LONGEST)])
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


@pytest.mark.parametrize(
    "name", [name if name in EACH else pytest.param(name, marks=pytest.mark.slow) for name in CASES]
)
def test_every_variant_renders(describe, plugins, name):
    """In this order, because a class must not outlive its variant; and two of a kind, which Mitsuba
    must not mix up."""
    plugins.clear()
    for variant in ("llvm_ad_spectral", "llvm_ad_mono", "llvm_ad_rgb"):
        mi.set_variant(variant)
        scene = mi.load_dict(spheres(describe(name), describe(name), size=4))
        picture = mi.render(scene, spp=8).numpy()
        assert np.isfinite(picture).all() and picture.min() > 0
