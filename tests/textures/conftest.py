"""Networks for latent textures: those that Urushi ships; and codes that vary over a texture."""

import numpy as np
import pytest

from urushi.nets import lobe as lobes
from urushi.nets.weights import Model, default_model


@pytest.fixture(scope="session")
def model() -> Model:
    return default_model()


@pytest.fixture(scope="session")
def lacquers(model):
    """From a number of texels: codes (n, 3, size) of lacquers over metals that shine and diffuse.

    A texel has one width of the lacquer, and in each channel a width of the metal, its reflectance
    and a diffuse reflectance.
    """

    def draw(count: int) -> np.ndarray:
        rng = np.random.default_rng(0)
        lobe = np.zeros((count, 3, 6))
        lobe[..., 0] = rng.uniform(0.05, 0.4, (count, 1))
        lobe[..., 3:5] = 1, 1.5
        metal = np.zeros((count, 3, 6))
        metal[..., 0] = rng.uniform(0.1, 0.4, (count, 3))
        metal[..., 1:3] = rng.uniform(0.1, 0.5, (count, 3, 1))
        metal[..., 4] = 1.5
        wi, wo = model.networks.pairs()
        f = lobes.f(lobe[..., None, :], wi, wo) + lobes.f(metal[..., None, :], wi, wo)
        f += rng.uniform(0.02, 0.4, (count, 3, 1)) / np.pi
        return model.networks.encode(f.astype(np.float32), lobe.astype(np.float32))

    return draw
