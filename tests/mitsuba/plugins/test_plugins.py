"""Loading the plugins: dictionaries and XML, nested in Mitsuba's BSDFs, in several variants."""

import numpy as np
import pytest
from tests.mitsuba.probes import f, update, walked

import urushi
from urushi.material import Material

COAT = {"alpha": 0.2, "int_ior": 1.4, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}
BOTTOM = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}
COATS = ("layered", "neural_layered")
WI, WO = (np.float32([w]) / np.linalg.norm(w) for w in ((0.3, 0.1, 0.9), (-0.5, 0.1, 0.6)))


@pytest.fixture
def saved(model, codes, tmp_path):
    """A file of a material."""
    path = tmp_path / "material.safetensors"
    Material(codes(), model).save(path)
    return path


@pytest.fixture
def describe(networks, saved, merl_file):
    """The dictionary of a plugin by its name."""
    weights = {"weights": str(networks)}
    described = {
        "layered": COAT | {"base": BOTTOM},
        "neural_layered": COAT | {"base": BOTTOM} | weights,
        "neural_brdf": {"filename": str(saved)} | weights,
        "measured_brdf": {"filename": str(merl_file)},
    }
    return lambda name: {"type": name} | described[name]


def xml(type: str, name: str = "", **properties) -> str:
    """A BSDF's dictionary as XML."""
    inner = ""
    for key, value in properties.items():
        if isinstance(value, dict):
            inner += xml(name=key, **value)
        else:
            tag = {float: "float", str: "string"}[value.__class__]
            inner += f'<{tag} name="{key}" value="{value}"/>'
    label = f'name="{name}"' if name else 'version="3.0.0"'
    return f'<bsdf type="{type}" {label}>{inner}</bsdf>'


@pytest.mark.parametrize("name", [*COATS, "neural_brdf", "measured_brdf"])
def test_dictionary_and_xml_are_the_same(rgb, describe, name):
    a, b = rgb.load_dict(describe(name)), rgb.load_string(xml(**describe(name)))
    assert str(a) == str(b)
    np.testing.assert_array_equal(f(a, WI, WO), f(b, WI, WO))


@pytest.mark.parametrize("name", COATS)
def test_nested_in_mitsubas_bsdfs(rgb, describe, name):
    """On the back of a surface, and as shares; the contract has wrappers that change nothing."""
    coat, down = rgb.load_dict(describe(name)), np.float32([1, 1, -1])
    two_sided = rgb.load_dict({"type": "twosided", "inner": coat})
    above, flipped = walked(coat, WI, WO, 4096), -walked(two_sided, WI * down, WO * down, 4096)
    error = 5 * (flipped.std(axis=0) + above.std(axis=0)) / 64 + 1e-4 * above.mean(axis=0)
    assert (np.abs(flipped.mean(axis=0) - above.mean(axis=0)) <= error).all()
    blend = {"type": "blendbsdf", "weight": 0.25, "a": coat, "b": {"type": "diffuse"}}
    mask = {"type": "mask", "opacity": 0.4, "inner": coat}
    alone = f(coat, WI, WO)
    for outer, expected in ((blend, 0.75 * alone + 0.25 * 0.5 / np.pi), (mask, 0.4 * alone)):
        np.testing.assert_allclose(f(rgb.load_dict(outer), WI, WO), expected, rtol=1e-5)


def test_one_word_changes_networks_to_walks(rgb, describe):
    """`layered` ignores what `neural_layered` adds."""
    plain = describe("layered")
    extended = rgb.load_dict(plain | {"resolution": 64, "weights": "default"})
    np.testing.assert_array_equal(f(extended, WI, WO), f(rgb.load_dict(plain), WI, WO))


@pytest.mark.parametrize("name", COATS)
def test_appearances_are_those_of_python(rgb, name):
    """The same media by color, body and thickness, and by the albedo and sigma_t of `coat`."""
    look = {"color": [0.9, 0.5, 0.2], "body": 0.4, "body_color": [0.3, 0.6, 0.8], "thickness": 1.5}
    (described,) = urushi.coat(urushi.diffuse(0.5), g=0.3, **look).coats
    physical = {n: list(getattr(described, n)) for n in ("albedo", "sigma_t")}
    found = []
    for medium in (look, physical):
        colours = {k: {"type": "rgb", "value": v} for k, v in medium.items() if type(v) is list}
        coat = {"type": name, "alpha": 0.2, "g": 0.3, **medium, **colours}
        plugin = rgb.load_dict(coat | {"base": {"type": "diffuse"}})
        found.append(walked(plugin, WI, WO, 4096).mean(axis=0))
    # The same random numbers, but walks may end at another event where an optical depth is rounded.
    np.testing.assert_allclose(*found, rtol=2e-3)


def test_a_coat_over_a_saved_material_follows_its_codes(rgb, describe, saved, model):
    inner, material = rgb.load_dict(describe("neural_brdf")), urushi.load(saved, model)
    coat = describe("neural_layered") | {"alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0}
    medium = {name: COAT[name] for name in ("albedo", "sigma_t", "g")}
    for _ in range(2):
        expected = urushi.layer(urushi.dielectric(0.1, 1.5), material, **medium)
        coated = rgb.load_dict(coat | {"base": inner}).latents.material
        np.testing.assert_allclose(coated.latents, expected.latents, rtol=1e-4, atol=1e-4)
        material = Material(material.latents + np.float32(0.1) * (np.arange(32) == 31), model)
        update(inner, {"latents": rgb.TensorXf(material.latents)})
