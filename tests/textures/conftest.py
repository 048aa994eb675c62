"""Networks for latent textures: untrained ones, and those that Urushi ships."""

import pytest

from urushi.nets.architecture import Architecture, init
from urushi.nets.weights import Model, default_model


@pytest.fixture(scope="session")
def model() -> Model:
    arch = Architecture()
    return Model.of(arch, init(arch, 0), {})


@pytest.fixture(scope="session")
def trained() -> Model:
    return default_model()
