"""Plugins and NumPy agree on materials with tables, bare and under coats."""

import drjit as dr
import numpy as np
import pytest
from tests.directions import pairs_above
from tests.mitsuba.probes import f, update, vector

import urushi
from urushi.core.table import SHAPE
from urushi.material import Material
from urushi.mitsuba.reading import probing
from urushi.nets.weights import Model


def random_table(seed: int) -> np.ndarray:
    """ln f (U, V, W, 3) that neighbouring nodes share roughly."""
    rng = np.random.default_rng(seed)
    slopes = rng.normal(size=(3, 3))
    nodes = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in SHAPE), indexing="ij"), axis=-1)
    return nodes @ slopes + 0.1 * rng.normal(size=(*SHAPE, 3)) - 1


def materials(model: Model) -> list[Material]:
    """With lobes that channels share or do not share, with none, and with one channel."""
    lobe = model.arch.lobe
    latents = np.random.default_rng(1).normal(size=(3, model.arch.latent)).astype(np.float32)
    numbers = [
        [[0.2, 0.5, 0.9, 0, 1.5, 0]] * 3,
        [[0.2, 0.5, 0.9, 0, 1.5, 0], [0.3, 0.2, 1, 0.5, 1.3, 0.4], [0.4, 0, 0, 1, 0.3, 3]],
        [[0.2, 0, 0, 0, 1.5, 0]] * 3,
    ]
    made = []
    for seed, values in enumerate(numbers):
        codes = np.concatenate([np.float32(values), latents[:, lobe:]], axis=1)
        made.append(Material(codes, model, random_table(seed)))
    return [*made, Material(made[0].latents[:1], model, made[0].table[..., :1])]


@pytest.fixture
def loaded(rgb, networks, tmp_path):
    """A function: the plugin of a material, which is saved."""

    def load(material):
        path = tmp_path / "material"
        material.save(path)
        described = {"type": "neural_brdf", "filename": str(path), "weights": str(networks)}
        return rgb.load_dict(described)

    return load


@pytest.fixture(scope="module")
def pairs():
    wi, wo = pairs_above(500, 1, 0.05)
    wo[:100] = wi[:100] * [-1, -1, 1]
    return wi, wo


def test_plugins_evaluate_as_numpy_does(loaded, model, pairs):
    for material in materials(model):
        found = f(loaded(material), *pairs)
        expected = np.broadcast_to(material.f(*pairs), found.shape)
        np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_saved_again_to_the_byte_and_edited(rgb, loaded, model, pairs, tmp_path):
    """Edited codes replace the table."""
    material = materials(model)[1]
    bsdf = loaded(material)
    bsdf.save(tmp_path / "again")
    assert (tmp_path / "again").read_bytes() == (tmp_path / "material").read_bytes()
    edited = np.array(material.latents)
    edited[:, -1] += np.float32(0.1)
    update(bsdf, {"latents": rgb.TensorXf(edited)})
    # The plugin's table of the codes' rest is in single precision.
    np.testing.assert_allclose(f(bsdf, *pairs), Material(edited, model).f(*pairs), rtol=1e-3)


def test_frozen_functions_tell_materials_apart(rgb, loaded, model, pairs):
    codes, (wi, wo) = materials(model)[0].latents, pairs
    frozen = dr.freeze(lambda bsdf, si, wo: bsdf.eval(rgb.BSDFContext(), si, wo))
    si = probing.interaction(wi, np.zeros((len(wi), 2)))
    made = [Material(codes, model, random_table(seed)) for seed in (5, 6)]
    bsdfs = [loaded(material) for material in made]
    for material, bsdf in zip(made, bsdfs, strict=True):
        found = frozen(bsdf, si, vector(wo)).numpy() / wo.T[2]
        np.testing.assert_allclose(found.T, material.f(wi, wo), rtol=2e-3)


def test_a_coat_over_a_saved_material_follows_its_codes(rgb, networks, loaded, model):
    material = Material(materials(model)[1].latents, model)
    inner, medium = loaded(material), {"albedo": 0.7, "sigma_t": 0.8, "g": 0.3}
    coat = {"type": "neural_layered", "weights": str(networks), "alpha": 0.1, "int_ior": 1.5}
    for _ in range(2):
        expected = urushi.layer(urushi.dielectric(0.1, ior=1.5), material, **medium)
        found = rgb.load_dict(coat | medium | {"base": inner}).latents.material
        np.testing.assert_allclose(found.latents, expected.latents, rtol=1e-4, atol=1e-4)
        material = Material(material.latents + np.float32(0.1) * (np.arange(32) == 31), model)
        update(inner, {"latents": rgb.TensorXf(material.latents)})


@pytest.mark.slow
def test_coats_over_measured_saved_and_coated_materials(rgb, merl_file, pairs, tmp_path):
    """As in Python; tables of coats are computed from those below."""
    medium, interface = {"sigma_t": (0.1, 0.4, 1.2)}, urushi.dielectric(0.1, 1.5)
    measured = urushi.encode(urushi.load_measured(merl_file))
    measured.save(tmp_path / "bare")
    coated = urushi.layer(interface, measured, **medium)

    def plugin(bottom):
        described = {"type": "neural_layered", "alpha": 0.1, "int_ior": 1.5, "ext_ior": 1.0}
        colour = {"type": "rgb", "value": list(medium["sigma_t"])}
        return rgb.load_dict(described | {"sigma_t": colour, "base": bottom})

    bsdf = plugin({"type": "measured_brdf", "filename": str(merl_file)})
    over_file = plugin({"type": "neural_brdf", "filename": str(tmp_path / "bare")})
    assert "with a table" in str(bsdf)
    assert bsdf.latents.material == over_file.latents.material == coated
    assert plugin(over_file).latents.material == urushi.layer(interface, coated, **medium)
    np.testing.assert_allclose(f(bsdf, *pairs), coated.f(*pairs), rtol=2e-3)
    bsdf.save(tmp_path / "a")
    again = rgb.load_dict({"type": "neural_brdf", "filename": str(tmp_path / "a")})
    np.testing.assert_array_equal(f(again, *pairs), f(bsdf, *pairs))
