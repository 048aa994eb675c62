"""Materials with tables are rendered as they are evaluated in NumPy."""

import drjit as dr
import numpy as np
import pytest
from tests.mitsuba.probes import f, update, vector
from tests.untrained import untrained

from urushi.core.table import SHAPE
from urushi.material import Material
from urushi.mitsuba.reading import probing
from urushi.nets import weights
from urushi.nets.weights import Model


def random_table(seed: int) -> np.ndarray:
    """ln f (U, V, W, 3) that neighbouring nodes share roughly."""
    rng = np.random.default_rng(seed)
    slopes = rng.normal(size=(3, 3))
    nodes = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in SHAPE), indexing="ij"), axis=-1)
    return nodes @ slopes + 0.1 * rng.normal(size=(*SHAPE, 3)) - 1


@pytest.fixture(scope="module")
def small() -> Model:
    return untrained(2)


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


def loaded(mi, material, folder):
    """The plugin of a saved material and the networks in a file."""
    weights.save(folder / "weights", material.model.arch, material.model.params, {})
    material.save(folder / "material")
    paths = {"filename": str(folder / "material"), "weights": str(folder / "weights")}
    return mi.load_dict({"type": "neural_brdf", **paths})


def test_plugins_evaluate_as_numpy_does(rgb, small, random_directions, tmp_path):
    wi, wo = random_directions(500, 1, 0.05), random_directions(500, 2, 0.05)
    wo[:100] = wi[:100] * [-1, -1, 1]
    for material in materials(small):
        found = f(loaded(rgb, material, tmp_path), wi, wo)
        expected = np.broadcast_to(material.f(wi, wo), found.shape)
        np.testing.assert_allclose(found, expected, rtol=2e-3)


def test_saved_again_to_the_byte(rgb, small, tmp_path):
    loaded(rgb, materials(small)[1], tmp_path).save(tmp_path / "again")
    assert (tmp_path / "again").read_bytes() == (tmp_path / "material").read_bytes()


def test_edited_codes_replace_them(rgb, small, random_directions, tmp_path):
    material = materials(small)[1]
    bsdf = loaded(rgb, material, tmp_path)
    edited = np.array(material.latents)
    edited[:, -1] += np.float32(0.1)
    update(bsdf, {"latents": rgb.TensorXf(edited)})
    wi, wo = random_directions(100, 1, 0.05), random_directions(100, 2, 0.05)
    of_codes = Material(edited, small).f(wi, wo)
    # The plugin's table of the codes' rest is in single precision.
    np.testing.assert_allclose(f(bsdf, wi, wo), of_codes, rtol=1e-3)


def test_frozen_functions_tell_materials_apart(rgb, small, random_directions, tmp_path):
    codes = materials(small)[0].latents
    made = [Material(codes, small, random_table(seed)) for seed in (5, 6)]
    bsdfs = [loaded(rgb, material, tmp_path) for material in made]
    wi, wo = random_directions(64, 1, 0.05), random_directions(64, 2, 0.05)

    frozen = dr.freeze(lambda bsdf, si, wo: bsdf.eval(rgb.BSDFContext(), si, wo))
    si = probing.interaction(wi, np.zeros((64, 2)))
    for bsdf, material in zip(bsdfs, made, strict=True):
        found = (frozen(bsdf, si, vector(wo)).numpy() / wo.T[2]).T
        np.testing.assert_allclose(found, material.f(wi, wo), rtol=2e-3)
