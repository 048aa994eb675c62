"""Untrained networks of Fan et al. 2022."""

import numpy as np
import pytest


@pytest.fixture(scope="session")
def params():
    """Random networks whose normalisations are not the identity."""
    from fan2022.architecture import init

    rng = np.random.default_rng(1)
    noise = {name: rng.normal(size=value.shape) for name, value in init(0).items()}
    return {name: value + np.float32(0.1 * noise[name]) for name, value in init(0).items()}


@pytest.fixture(scope="session")
def positive():
    """Random networks whose values are positive nearly everywhere."""
    from fan2022.architecture import init

    params = init(3)
    return params | {"evaluation.3.bias": params["evaluation.3.bias"] + np.float32(0.5)}
