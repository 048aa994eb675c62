"""The penalty for an f that rises with absorption."""

import jax.numpy as jnp
import numpy as np
import pytest

from urushi.nets.architecture import Architecture, init
from urushi.nets.features import COAT_TABLE
from urushi.nets.lobe import LOBE_FEATURES, NO_LOBE
from urushi.train.stages.joint import ABSORPTION_STEPS, absorption_penalty, with_more_absorption

ARCH = Architecture(latent=10, decoder=(8,), encoder=(8,), layerer=(8,), sampler=(4,), probes=6)


@pytest.fixture
def coats():
    rng = np.random.default_rng(3)
    low, high = np.array([[0.01, 1.05, 0, 0, -0.8], [1, 2, 1, 8, 0.9]], np.float32)
    return low + (high - low) * rng.random((7, 5), np.float32)


def test_only_absorption_is_added(coats):
    darker = np.asarray(with_more_absorption(jnp.asarray(coats)))
    np.testing.assert_array_equal(darker[:, [0, 1, 4]], coats[:, [0, 1, 4]])
    scattering, extinction = coats[:, 2] * coats[:, 3], coats[:, 3]
    np.testing.assert_allclose(darker[:, 2] * darker[:, 3], scattering, rtol=1e-5, atol=1e-6)
    added = np.array([ABSORPTION_STEPS[row % len(ABSORPTION_STEPS)] for row in range(len(coats))])
    np.testing.assert_allclose(darker[:, 3] - extinction, added, rtol=1e-5)


@pytest.mark.parametrize("sign", [-1, 1])
def test_only_a_network_that_brightens_with_absorption_is_penalised(coats, sign):
    # All weights are zero except on one path: from the feature ln(1 + sigma_t (1 - albedo)), which
    # grows with absorption, through one neuron to the gain.
    params = {name: np.zeros_like(value) for name, value in init(ARCH, 0).items()}
    table = [formula for formula, _, _ in COAT_TABLE]
    absorbed = table.index("ln(1 + sigma_t (1 - albedo))")
    params["layerer.0.weight"][ARCH.latent - ARCH.lobe + LOBE_FEATURES[1] + absorbed, 0] = 1
    params["layerer.1.weight"][0, 0] = sign
    params["layerer.0.bias"][0] = 5  # where the activation grows
    features = np.zeros((7, 3, 8), np.float32)
    penalty = np.asarray(
        absorption_penalty(
            params,
            ARCH,
            np.tile(np.array((*NO_LOBE, 0, 0, 0, 0), np.float32), (7, 1)),
            coats,
            features,
        )
    )
    assert penalty.shape == (7, 3)
    assert (penalty > 0).all() if sign > 0 else (penalty == 0).all()
