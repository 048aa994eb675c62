"""Materials of an untrained layering network, for properties that hold for any weights."""

import numpy as np
import pytest
from benchmarks.measures import stack_error
from tests.untrained import untrained

import urushi
from urushi.material import Material, encode, layer
from urushi.nets import lobe as lobes
from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model, default_model

#: Codes of a dielectric, of a metal and of no lobe, over random rests.
LOBES = [[0.2, 0, 0, 1, 1.5, 0], [0.1, 0.8, 1, 0, 1.5, 0], NO_LOBE]


def random_rests(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Rests (*shape, K) of codes of untrained models."""
    return rng.normal(size=(*shape, 8))


@pytest.fixture(scope="session")
def draw_codes():
    """From a shape and a generator: codes float32 (*shape, L) with lobes of all kinds."""

    def draw(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
        lobes = np.array(LOBES)[rng.integers(len(LOBES), size=shape)]
        return np.concatenate([lobes, random_rests(shape, rng)], axis=-1).astype(np.float32)

    return draw


@pytest.fixture(scope="session")
def model() -> Model:
    return untrained(0)


@pytest.fixture(scope="session")
def other_model() -> Model:
    return untrained(1)


@pytest.fixture(scope="session")
def material(model) -> Material:
    rests = random_rests((3,), np.random.default_rng(41))
    return Material(np.concatenate([LOBES, rests], axis=1), model)


@pytest.fixture(scope="session")
def trained() -> Model:
    """The networks that Urushi ships."""
    return default_model()


def error(f, expected, wi, wo) -> np.ndarray:
    """E of materials or values at pairs, of each channel if they have channels."""
    f, expected = (x.f(wi, wo) if isinstance(x, Material) else x for x in (f, expected))
    f, expected = np.broadcast_arrays(np.transpose(f), np.transpose(expected))
    return stack_error(f, expected, wi[:, 2], wo[:, 2])


def with_gain(model: Model, log_gain: float) -> Model:
    """The model with a basis whose mean is higher by a logarithm."""
    rows = model.params["basis.rows"].copy()
    rows[:, 0] += np.float32(log_gain)
    return Model.of(model.arch, dict(model.params) | {"basis.rows": rows}, {})


def velvet(wi, wo):
    """Brighter at grazing angles, over a narrow lobe: unlike any layered material."""
    h = wi + wo
    cos_h = h[:, 2] / np.linalg.norm(h, axis=1)
    cosines = np.maximum(wi[:, 2], 0.05) + np.maximum(wo[:, 2], 0.05)
    sheen = 0.06 * np.exp(-2 * cosines)
    lobe = 0.02 / (np.pi * (cos_h**2 * (0.1**2 - 1) + 1) ** 2) * 0.1**2
    return np.stack([sheen + 0.01, sheen + lobe, 0.3 * lobe + 0.03], axis=1)


def two_lobes(wi, wo):
    """A narrow and a wide lobe of metals over a diffuse term."""
    lobe = np.float32([[0.02, 0.2, 1, 0, 1.5, 0], [0.15, 0.5, 1, 0, 1.5, 0]])
    return lobes.f(lobe, wi[:, None], wo[:, None]).sum(axis=1) + 0.05


@pytest.fixture(scope="session")
def tabulated(model) -> Material:
    """A material with a table of all of f."""
    return encode(velvet, model, table=True)


@pytest.fixture(scope="session", params=["codes", "table", "table beside a lobe", "two widths"])
def every(request, material, tabulated) -> Material:
    """A material of each kind."""
    medium = {"albedo": (0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3}
    if request.param == "table beside a lobe":
        return layer(urushi.dielectric(0.1, 1.4), tabulated, **medium)
    if request.param == "two widths":
        brushed = urushi.conductor(alpha_u=0.3, alpha_v=0.08, eta=0.2, k=3.9)
        return layer(urushi.dielectric(0.15, 1.5), brushed, **medium)
    return material if request.param == "codes" else tabulated
