"""Materials of untrained networks with analytic lobes, for properties that hold for any weights."""

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.core.table import SHAPE, knots_of
from urushi.material import Material
from urushi.nets.basis import EMPTY_GAIN
from urushi.nets.weights import Model

COUNT = 4096


@pytest.fixture(scope="session")
def model() -> Model:
    return untrained(3)


@pytest.fixture(scope="session")
def anisotropic_model() -> Model:
    return untrained(3, widths=2, azimuthal=(1, 1, 1, 1, 1))


@pytest.fixture(scope="session")
def materials(model) -> dict[str, Material]:
    """Materials by what is special in them."""
    rng = np.random.default_rng(5)
    codes = rng.normal(size=(3, model.arch.latent)).astype(np.float32)
    codes[:, 0] = 0.15, 0.2, 0.3
    codes[:, 1:4] = rng.uniform(0, 0.5, (3, 3))
    codes[:, 4:6] = (1.5, 0), (0.8, 2), (0.3, 3)
    coat, bare, smooth, edges = (codes.copy() for _ in range(4))
    coat[:, :6] = 0.1, 0, 0, 1, 1.5, 0  # the same in all channels
    bare[:, :6] = 1, 0, 0, 0, 1.5, 0
    smooth[:, 6] = EMPTY_GAIN
    edges[:, 3:6] = (1, 0.7, 0), (0.6, 0.55, 0), (0.5, 0.3, 3)  # to thinner media, and a metal
    places = np.meshgrid(*(np.linspace(0, 9, count) for count in SHAPE), indexing="ij")
    logs = -1 + np.sin(np.stack(places, axis=-1) + np.sum(places, axis=0)[..., None])
    return {
        "three lobes": Material(codes, model),
        "one lobe": Material(coat, model),
        "no lobe": Material(bare, model),
        "no rest": Material(smooth, model),
        "grey": Material(codes[:1], model),
        "edges": Material(edges, model),
        "grey edges": Material(edges[:1], model),
        "table": Material(codes, model, logs),
        "table beside lobe": Material(
            codes[:1], model, logs[..., :1], beside_lobe=True, knots=knots_of([0.5, 0.8])
        ),
    }


@pytest.fixture(scope="session")
def anisotropic_materials(anisotropic_model) -> dict[str, Material]:
    """Anisotropic materials by what is special in them."""
    rng = np.random.default_rng(6)
    codes = rng.normal(size=(3, anisotropic_model.arch.latent)).astype(np.float32)
    codes[:, 0], codes[:, 6] = (0.15, 0.3, 0.4), (0.4, 0.2, 0.1)
    codes[:, -1] = 0.25  # channels share the stretch
    codes[:, 1:4] = rng.uniform(0, 0.5, (3, 3))
    codes[:, 4:6] = (1.5, 0), (0.8, 2), (0.3, 3)
    coat = codes.copy()
    coat[:, :7] = 0.12, 0, 0, 1, 1.5, 0, 0.4  # the same in all channels
    edges = codes.copy()
    edges[:, 3:6] = (1, 0.7, 0), (0.6, 0.55, 0), (0.5, 0.3, 3)
    return {
        "three lobes": Material(codes, anisotropic_model),
        "one lobe": Material(coat, anisotropic_model),
        "turned": Material(codes, anisotropic_model, rotation=40.0),
        "grey": Material(codes[:1], anisotropic_model),
        "edges": Material(edges, anisotropic_model),
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
