"""Materials of untrained networks with analytic lobes, for properties that hold for any weights."""

import numpy as np
import pytest

from urushi.material import Material
from urushi.nets.architecture import SCALE, Architecture, init
from urushi.nets.weights import Model

COUNT = 4096


@pytest.fixture(scope="session")
def model() -> Model:
    arch = Architecture(
        latent=24,
        decoder=(16, 16),
        layerer=(16,),
        encoder=(16,),
        sampler=(16,),
        activation="silu7",
    )
    return _untrained(arch)


@pytest.fixture(scope="session")
def anisotropic_model() -> Model:
    arch = Architecture(
        latent=24,
        decoder=(16, 16),
        layerer=(16,),
        encoder=(16,),
        sampler=(16,),
        activation="silu7",
        widths=2,
    )
    return _untrained(arch)


def _untrained(arch: Architecture) -> Model:
    """Random parameters of a size at which f and the proposal vary much."""
    params = init(arch, 3)
    rng = np.random.default_rng(3)
    params[SCALE] = rng.normal(size=params[SCALE].shape).astype(np.float32) * 0.2
    params["decoder.2.weight"] = params["decoder.2.weight"] * 3
    params["sampler.1.weight"] = params["sampler.1.weight"] * 10
    return Model.of(arch, params, {})


@pytest.fixture(scope="session")
def materials(model) -> dict[str, Material]:
    """Materials by what is special in them."""
    rng = np.random.default_rng(5)
    codes = rng.normal(size=(3, 24)).astype(np.float32)
    codes[:, 0] = 0.15, 0.2, 0.3
    codes[:, 1:4] = rng.uniform(0, 0.5, (3, 3))
    codes[:, 4:6] = (1.5, 0), (0.8, 2), (0.3, 3)
    coat, bare = codes.copy(), codes.copy()
    coat[:, :6] = 0.1, 0, 0, 1, 1.5, 0  # the same in all channels
    bare[:, :6] = 1, 0, 0, 0, 1.5, 0
    return {
        "three lobes": Material(codes, model),
        "one lobe": Material(coat, model, coat + np.float32(0.1)),
        "no lobe": Material(bare, model),
        "grey": Material(codes[:1], model),
    }


@pytest.fixture(scope="session")
def anisotropic_materials(anisotropic_model) -> dict[str, Material]:
    """Anisotropic materials by what is special in them."""
    rng = np.random.default_rng(6)
    codes = rng.normal(size=(3, 24)).astype(np.float32)
    codes[:, 0], codes[:, 6] = (0.15, 0.3, 0.4), (0.4, 0.2, 0.1)
    codes[:, 1:4] = rng.uniform(0, 0.5, (3, 3))
    codes[:, 4:6] = (1.5, 0), (0.8, 2), (0.3, 3)
    coat = codes.copy()
    coat[:, :7] = 0.12, 0, 0, 1, 1.5, 0, 0.4  # the same in all channels
    return {
        "three lobes": Material(codes, anisotropic_model),
        "one lobe": Material(coat, anisotropic_model, coat + np.float32(0.1)),
        "turned": Material(codes, anisotropic_model, codes - np.float32(0.1), rotation=40.0),
        "grey": Material(codes[:1], anisotropic_model),
    }


@pytest.fixture(scope="session")
def rows() -> np.ndarray:
    """wi, wo and u of `gpu.run`: half the pairs are near the mirror direction, some below."""
    rng = np.random.default_rng(7)
    rows = np.zeros((COUNT, 12), np.float32)
    directions = rng.normal(size=(2, COUNT, 3))
    directions[:, 64:, 2] = abs(directions[:, 64:, 2])
    half = slice(COUNT // 2, None)
    directions[1, half] = directions[0, half] * (-1, -1, 1) + rng.normal(size=(COUNT // 2, 3)) / 9
    directions[1, half, 2] = abs(directions[1, half, 2])
    directions[0, 100:108], directions[1, 104:112] = (0, 0, 1), (0, 0, 1)  # no azimuth
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    rows[:, :3], rows[:, 4:7] = directions
    rows[:, 8:11] = rng.random((COUNT, 3), np.float32)
    return rows
