"""Loading the plugins: dictionaries and XML, nested in Mitsuba's BSDFs, in several variants."""

import numpy as np
import pytest
from tests.mitsuba.probes import vector

from urushi.material import Material
from urushi.mitsuba.reading import probing

COAT = {"alpha": 0.2, "int_ior": 1.4, "albedo": 0.7, "sigma_t": 0.8, "g": 0.3}
PLUGINS = (
    "layered",
    "neural_layered",
    "neural_brdf",
    "measured_brdf",
)


def bottom() -> dict:
    return {"type": "roughconductor", "distribution": "ggx", "alpha": 0.3}


@pytest.fixture
def saved(model, codes, tmp_path):
    """A file of a material."""
    path = tmp_path / "material.safetensors"
    Material(codes(), model).save(path)
    return path


@pytest.fixture
def describe(networks, saved, merl_file):
    """The dictionary of a plugin by its name."""
    described = {
        "layered": {"type": "layered", **COAT, "base": bottom()},
        "neural_layered": {
            "type": "neural_layered",
            **COAT,
            "base": bottom(),
            "weights": str(networks),
        },
        "neural_brdf": {
            "type": "neural_brdf",
            "filename": str(saved),
            "weights": str(networks),
        },
        "measured_brdf": {"type": "measured_brdf", "filename": str(merl_file)},
    }
    return described.__getitem__


def evaluate(bsdf, wi=(0.3, 0.1, 0.9), wo=(-0.5, 0.1, 0.6), count=1, repeat=0.0) -> np.ndarray:
    """f cos (count, channels)."""
    wi, wo = (np.tile(np.float32(w) / np.linalg.norm(w), (count, 1)) for w in (wi, wo))
    import mitsuba as mi

    si = probing.interaction(wi, np.random.default_rng(0).random((count, 2)), repeat)
    value = bsdf.eval(mi.BSDFContext(), si, vector(wo))
    return np.stack(np.broadcast_arrays(*(channel.numpy() for channel in value)), -1)


@pytest.mark.parametrize("name", PLUGINS)
def test_dictionary_and_xml_are_the_same(rgb, describe, name):
    properties = describe(name)
    tags = {float: "float", str: "string"}
    lines = [
        f'<{tags[type(value)]} name="{key}" value="{value}"/>'
        for key, value in properties.items()
        if type(value) in tags and key != "type"
    ]
    if "base" in properties:
        lines.append(
            '<bsdf type="roughconductor"><string name="distribution" value="ggx"/>'
            '<float name="alpha" value="0.3"/></bsdf>'
        )
    xml = f'<bsdf type="{name}" version="3.0.0">{"".join(lines)}</bsdf>'
    a, b = rgb.load_dict(properties), rgb.load_string(xml)
    assert str(a) == str(b)
    np.testing.assert_array_equal(evaluate(a), evaluate(b))


@pytest.mark.parametrize("name", ["layered", "neural_layered"])
def test_nested_in_mitsubas_bsdfs(rgb, describe, name):
    plain = rgb.load_dict(describe(name))
    f = evaluate(plain)
    assert (f > 0).all()
    two_sided = rgb.load_dict({"type": "twosided", "inner": describe(name)})
    np.testing.assert_allclose(evaluate(two_sided), f, rtol=1e-5)
    flipped = evaluate(two_sided, wi=(0.3, 0.1, -0.9), wo=(-0.5, 0.1, -0.6), count=4096)
    above = evaluate(plain, count=4096)  # other bits, other walks: compare means
    error = 5 * (flipped.std(axis=0) + above.std(axis=0)) / 64 + 1e-4 * above.mean(axis=0)
    assert (np.abs(flipped.mean(axis=0) - above.mean(axis=0)) <= error).all()
    blend = rgb.load_dict(
        {"type": "blendbsdf", "weight": 0.25, "a": describe(name), "b": {"type": "diffuse"}}
    )
    diffuse = evaluate(rgb.load_dict({"type": "diffuse"}))
    np.testing.assert_allclose(evaluate(blend), 0.75 * f + 0.25 * diffuse, rtol=1e-5)
    mask = rgb.load_dict({"type": "mask", "opacity": 0.4, "inner": describe(name)})
    np.testing.assert_allclose(evaluate(mask), 0.4 * f, rtol=1e-5)


def test_one_word_changes_networks_to_walks(rgb, describe):
    """`layered` ignores what `neural_layered` adds."""
    extra = {"resolution": 64, "weights": "default"}
    plain = describe("layered")
    np.testing.assert_array_equal(
        evaluate(rgb.load_dict(plain | extra)), evaluate(rgb.load_dict(plain))
    )


LOOK = {"color": [0.9, 0.5, 0.2], "body": 0.4, "body_color": [0.3, 0.6, 0.8], "thickness": 1.5}


def with_look(name: str, **changes) -> dict:
    """A plugin whose medium is given by its appearance, over a Lambertian bottom."""
    values = {**LOOK, **changes}
    rgb = {k: {"type": "rgb", "value": v} for k, v in values.items() if isinstance(v, list)}
    return {"type": name, "alpha": 0.2, "g": 0.3, **values, **rgb, "base": {"type": "diffuse"}}


@pytest.mark.parametrize("name", ("layered", "neural_layered"))
def test_appearances_are_those_of_python(rgb, name):
    """The same media by color, body and thickness, and by the albedo and sigma_t of `coat`."""
    from urushi import coat, diffuse

    plugin = rgb.load_dict(with_look(name))
    (described,) = coat(diffuse(0.5), g=0.3, **LOOK).coats
    medium = {
        n: {"type": "rgb", "value": list(getattr(described, n))} for n in ("albedo", "sigma_t")
    }
    physical = {"type": name, "alpha": 0.2, "g": 0.3, **medium, "base": {"type": "diffuse"}}
    a, b = (evaluate(x, count=4096) for x in (plugin, rgb.load_dict(physical)))
    # The same random numbers, but walks may end at another event where an optical depth is rounded.
    np.testing.assert_allclose(a.mean(axis=0), b.mean(axis=0), rtol=2e-3)
    parameters = rgb.traverse(plugin)
    parameters["thickness.value"] = 0.5
    parameters.update()
    thinner = rgb.load_dict(with_look(name, thickness=0.5))
    np.testing.assert_allclose(evaluate(plugin), evaluate(thinner), rtol=1e-5)


def test_a_coat_over_a_saved_material_follows_its_codes(rgb, saved, networks, model):
    from urushi.material import layer, load
    from urushi.walk import dielectric

    weights = {"weights": str(networks)}
    inner = rgb.load_dict({"type": "neural_brdf", "filename": str(saved), **weights})
    coat = {"type": "neural_layered", "alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0, **weights}
    parameters = rgb.traverse(inner)
    material = load(saved, model)
    for _ in range(2):
        expected = layer(dielectric(0.1, 1.5), material)
        coated = rgb.load_dict(coat | {"base": inner}).latents.material
        np.testing.assert_allclose(coated.latents, expected.latents, rtol=1e-4, atol=1e-4)
        material = Material(material.latents + np.float32(0.1) * (np.arange(32) == 31), model)
        parameters["latents"] = rgb.TensorXf(material.latents)
        parameters.update()
