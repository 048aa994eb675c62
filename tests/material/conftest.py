"""Materials of untrained networks, for properties that hold for any weights."""

import numpy as np
import pytest

from urushi import paper
from urushi.material import Material
from urushi.nets.architecture import Architecture, init
from urushi.nets.weights import Model, default_model

paper.register()  # some tests use its networks, which have no gain and no derivatives

RGB = np.random.default_rng(41).normal(size=(3, 32)).astype(np.float32)


def make_model(seed: int) -> Model:
    arch = Architecture()
    params = init(arch, seed)
    params["decoder.3.weight"] = params["decoder.3.weight"] * 5  # some orders of magnitude in f
    params["sampler.2.weight"] = params["sampler.2.weight"] * 10
    return Model.of(arch, params, {})


@pytest.fixture(scope="session")
def model() -> Model:
    return make_model(0)


@pytest.fixture(scope="session")
def other_model() -> Model:
    return make_model(1)


@pytest.fixture(scope="session")
def material(model) -> Material:
    return Material(RGB, model)


@pytest.fixture(scope="session")
def trained() -> Model:
    """The networks that Urushi ships."""
    return default_model()
