"""Untrained networks of Fan et al. 2022."""

import numpy as np
import pytest
from fan2022 import PaperNetworks
from fan2022.architecture import PaperArchitecture, init


@pytest.fixture(scope="session")
def params():
    """Random networks whose normalisations are not the identity."""
    rng = np.random.default_rng(1)
    noise = {name: rng.normal(size=value.shape) for name, value in init(0).items()}
    return {name: value + np.float32(0.1 * noise[name]) for name, value in init(0).items()}


@pytest.fixture(scope="session")
def positive():
    """Random networks whose values are mostly positive, and whose proposals differ."""
    params = init(5)
    bias = params["evaluation.3.bias"] + np.float32(0.3)
    return params | {"evaluation.3.bias": bias, "proxy.4.weight": 20 * params["proxy.4.weight"]}


@pytest.fixture(scope="session")
def paper(positive):
    """Their weights, with projections of few steps, so that tests are quick."""
    return PaperNetworks(PaperArchitecture(steps=2, pairs=64), positive, {})


@pytest.fixture(scope="session")
def weights(paper, tmp_path_factory):
    """The path of their file."""
    path = tmp_path_factory.mktemp("paper") / "weights.safetensors"
    paper.save(path)
    return path
