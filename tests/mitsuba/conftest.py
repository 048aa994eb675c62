"""Small random networks, a saved material, and BSDFs to nest, for the plugins' tests."""

from pathlib import Path

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.measured import merl, tabulated
from urushi.nets import weights
from urushi.nets.lobe import NO_LOBE
from urushi.nets.weights import Model


@pytest.fixture(scope="session")
def networks(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A file of untrained networks with very different materials; codes have 32 numbers.

    The proposal's terms are scaled up, so that its mixtures have from one lobe to all lobes.
    """
    model = untrained(3, functions=26, layerer=(24,))
    params = dict(model.params)
    params["proposal.weight"] = 3 * params["proposal.weight"]
    path = tmp_path_factory.mktemp("weights") / "small.safetensors"
    weights.save(path, model.arch, params, {})
    return path


@pytest.fixture(scope="session")
def codes():
    """From a seed and a factor: codes (3, 32) of a dielectric, a metal and no lobe."""

    def draw(seed: int = 0, scale: float = 1.0) -> np.ndarray:
        lobes = [[0.2, 0, 0, 1, 1.5, 0], [0.1, 0.8, 1, 0, 1.5, 0], NO_LOBE]
        rest = np.random.default_rng(seed).normal(size=(3, 26)) * scale
        return np.concatenate([lobes, rest], axis=1).astype(np.float32)

    return draw


@pytest.fixture(scope="session")
def model(networks: Path) -> Model:
    """The same networks, loaded."""
    return weights.read(networks)


def _plastic(wi, wo):
    """A coloured GGX-like lobe of width 0.15 on a Lambertian base: reciprocal."""
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    alpha2 = 0.15**2
    lobe = alpha2 / (np.pi * (h[:, 2] ** 2 * (alpha2 - 1) + 1) ** 2)
    shadow = 0.1 / np.maximum(wi[:, 2] + wo[:, 2], 0.05)
    return np.array([0.6, 0.3, 0.1]) / np.pi + (lobe * shadow)[:, None] * [1.0, 0.8, 0.5]


@pytest.fixture(scope="session")
def merl_file(tmp_path_factory):
    """A MERL file of a plastic."""
    rows = tabulated.tabulated(_plastic, merl.SHAPE).reshape(-1, 3)
    path = tmp_path_factory.mktemp("merl") / "plastic.binary"
    with path.open("wb") as file:
        file.write(merl.HEADER)
        (rows / np.array(merl.SCALE)).T.astype("<f8").tofile(file)
    return path
