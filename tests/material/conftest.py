"""Materials of untrained networks, for properties that hold for any weights."""

import numpy as np
import pytest

from urushi.material import Material
from urushi.nets.architecture import SCALE, Architecture, init
from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model, default_model

#: Codes of a dielectric, of a metal and of no lobe, over random rests.
LOBES = [[0.2, 0, 0, 1, 1.5, 0], [0.1, 0.8, 1, 0, 1.5, 0], NO_LOBE]
RGB = np.concatenate([LOBES, np.random.default_rng(41).normal(size=(3, 26))], axis=1)
RGB = RGB.astype(np.float32)


def make_model(seed: int) -> Model:
    arch = Architecture()
    params = init(arch, seed)
    params["decoder.3.weight"] = params["decoder.3.weight"] * 5  # some orders of magnitude in f
    params["sampler.2.weight"] = params["sampler.2.weight"] * 10
    return Model.of(arch, params, {})


@pytest.fixture(scope="session")
def draw_codes():
    """From a shape and a generator: codes float32 (*shape, 32) with lobes of all kinds."""

    def draw(shape: tuple[int, ...], rng: np.random.Generator) -> np.ndarray:
        lobes = np.array(LOBES)[rng.integers(len(LOBES), size=shape)]
        return np.concatenate([lobes, rng.normal(size=(*shape, 26))], axis=-1).astype(np.float32)

    return draw


@pytest.fixture(scope="session")
def model() -> Model:
    return make_model(0)


@pytest.fixture(scope="session")
def other_model() -> Model:
    return make_model(1)


@pytest.fixture(scope="session")
def material(model) -> Material:
    return Material(RGB, model)


def make_small(seed: int) -> Model:
    arch = Architecture(
        latent=24, decoder=(24, 24), layerer=(64,), encoder=(64,), sampler=(16,), lobes=1
    )
    params = init(arch, seed)
    rng = np.random.default_rng(seed)
    params[SCALE] = rng.normal(size=params[SCALE].shape).astype(np.float32) * 0.2
    params["decoder.2.weight"] = params["decoder.2.weight"] * 3
    params["decoder.2.bias"] = params["decoder.2.bias"] - 3
    return Model.of(arch, params, {})


@pytest.fixture(scope="session")
def small() -> Model:
    """Untrained networks of about the shipped size."""
    return make_small(3)


@pytest.fixture(scope="session")
def other_small() -> Model:
    return make_small(4)


@pytest.fixture(scope="session")
def trained() -> Model:
    """The networks that Urushi ships."""
    return default_model()
