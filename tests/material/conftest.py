"""Materials of an untrained layering network, for properties that hold for any weights."""

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.material import Material
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
