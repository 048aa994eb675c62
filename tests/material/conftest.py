"""Materials of an untrained layering network, for properties that hold for any weights."""

from dataclasses import replace

import numpy as np
import pytest

from urushi.material import Material
from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model, default_model

#: Codes of a dielectric, of a metal and of no lobe, over random rests.
LOBES = [[0.2, 0, 0, 1, 1.5, 0], [0.1, 0.8, 1, 0, 1.5, 0], NO_LOBE]


def random_rests(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
    """Rests (*shape, K) of codes as spread as those of the training materials."""
    covariance = np.linalg.inv(default_model().params["basis.prior"].astype(np.float64))
    return 0.3 * rng.multivariate_normal(np.zeros(len(covariance)), covariance, size=shape)


def make_model(seed: int, layerer: tuple[int, ...] = (64, 64)) -> Model:
    """The shipped basis with a random layering network."""
    shipped, rng = default_model(), np.random.default_rng(seed)
    arch = replace(shipped.arch, layerer=layerer)
    params = dict(shipped.params)
    for name, shape in arch.parameter_shapes().items():
        if not name.startswith("basis."):
            params[name] = rng.normal(size=shape) * (shape[0] ** -0.5 if len(shape) == 2 else 0.1)
    return Model.of(arch, params, {})


@pytest.fixture(scope="session")
def draw_codes():
    """From a shape and a generator: codes float32 (*shape, L) with lobes of all kinds."""

    def draw(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
        lobes = np.array(LOBES)[rng.integers(len(LOBES), size=shape)]
        return np.concatenate([lobes, random_rests(shape, rng)], axis=-1).astype(np.float32)

    return draw


@pytest.fixture(scope="session")
def model() -> Model:
    return make_model(0)


@pytest.fixture(scope="session")
def other_model() -> Model:
    return make_model(1)


@pytest.fixture(scope="session")
def material(model) -> Material:
    rests = random_rests((3,), np.random.default_rng(41))
    return Material(np.concatenate([LOBES, rests], axis=1), model)


@pytest.fixture(scope="session")
def small() -> Model:
    return make_model(3)


@pytest.fixture(scope="session")
def other_small() -> Model:
    return make_model(4)


@pytest.fixture(scope="session")
def trained() -> Model:
    """The networks that Urushi ships."""
    return default_model()
