"""Materials of untrained networks with analytic lobes, for properties that hold for any weights."""

import numpy as np
import pytest
from tests.untrained import untrained

from urushi.core.table import SHAPE
from urushi.material import Material
from urushi.nets.basis import EMPTY_GAIN
from urushi.nets.weights import Model
from urushi.textures.packing import Texture

COUNT = 4096

#: Exact parts, indices and k of lobes: two of interfaces to thinner media, and a metal.
EDGES = (1, 0.7, 0), (0.6, 0.55, 0), (0.5, 0.3, 3)


@pytest.fixture(scope="session")
def model() -> Model:
    return untrained(3)


@pytest.fixture(scope="session")
def anisotropic_model() -> Model:
    return untrained(3, widths=2, azimuthal=(1, 1, 1, 1, 1))


@pytest.fixture(scope="session")
def materials(model, anisotropic_model) -> dict[str, Material]:
    """Materials by what is special in them, those of two widths last."""
    rng = np.random.default_rng(5)
    codes = _codes(rng, model)
    codes[:, 0] = 0.15, 0.2, 0.3
    coat, bare, smooth, edges = (codes.copy() for _ in range(4))
    coat[:, :6] = 0.1, 0, 0, 1, 1.5, 0  # the same in all channels
    bare[:, :6] = 1, 0, 0, 0, 1.5, 0
    smooth[:, 6] = EMPTY_GAIN
    edges[:, 3:6] = EDGES
    places = np.meshgrid(*(np.linspace(0, 9, count) for count in SHAPE), indexing="ij")
    logs = -1 + np.sin(np.stack(places, axis=-1) + np.sum(places, axis=0)[..., None])
    two = _codes(rng, anisotropic_model)
    two[:, 0], two[:, 6] = (0.15, 0.3, 0.4), (0.4, 0.2, 0.1)
    two[:, -1] = 0.25  # channels share the stretch
    brushed, brushed_edges = two.copy(), two.copy()
    brushed[:, :7] = 0.12, 0, 0, 1, 1.5, 0, 0.4
    brushed_edges[:, 3:6] = EDGES
    return {
        "three lobes": Material(codes, model),
        "one lobe": Material(coat, model),
        "no lobe": Material(bare, model),
        "no rest": Material(smooth, model),
        "grey": Material(codes[:1], model),
        "edges": Material(edges, model),
        "grey edges": Material(edges[:1], model),
        "table": Material(codes, model, logs),
        "table beside lobe": Material(codes[:1], model, logs[..., :1], beside_lobe=True),
        "brushed lobes": Material(two, anisotropic_model, rotation=40.0),
        "brushed lobe": Material(brushed, anisotropic_model),
        "brushed grey": Material(two[:1], anisotropic_model),
        "brushed edges": Material(brushed_edges, anisotropic_model),
    }


def _codes(rng: np.random.Generator, model: Model) -> np.ndarray:
    """Random codes (3, L) whose channels have lobes of their own: of coats and of metals."""
    codes = rng.normal(size=(3, model.arch.latent)).astype(np.float32)
    codes[:, 1:4] = rng.uniform(0, 0.5, (3, 3))
    codes[:, 4:6] = (1.5, 0), (0.8, 2), (0.3, 3)
    return codes


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


@pytest.fixture(scope="session")
def packed(model) -> Texture:
    return texture_of(model)


def texture_of(model: Model, eta: float = 1.5) -> Texture:
    """A texture of 8 x 4 texels; some numbers are constant, or the same in all channels.

    eta: of the interfaces of half of the texels; the others have 1.5.
    """
    rng = np.random.default_rng(2)
    codes = rng.normal(size=(32, 3, model.arch.latent)).astype(np.float32)
    codes[..., 0] = rng.uniform(0.1, 0.4, (len(codes), 1))
    codes[..., 1:6] = 0, 0, 1, 1.5, 0
    codes[::2, :, 4] = eta
    if model.widths == 2:
        codes[..., 6] = rng.uniform(0.1, 0.4, (len(codes), 1))
        codes[..., -1] = 0.25  # the stretch
    return Texture.of(model, codes)
