"""Random pairs of directions that reach into every corner, and networks with random weights."""

import numpy as np
import pytest

from urushi.nets.architecture import Architecture, init


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


@pytest.fixture(scope="session")
def pairs() -> tuple[np.ndarray, np.ndarray]:
    """2,003 pairs on the upper hemisphere: any, near the mirror direction, grazing, degenerate."""
    rng = np.random.default_rng(11)
    wi, wo = (_unit(rng.normal(size=(2000, 3))) for _ in range(2))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    mirrored = wi[:500] * [-1, -1, 1] + 1e-3 * rng.normal(size=(500, 3))
    wo[:500] = _unit(mirrored * [1, 1, 0] + [0, 0, 1] * np.abs(mirrored))
    wi[500:700, 2] *= 1e-4
    wi[500:700] = _unit(wi[500:700])
    corners = (
        np.array([[0, 0, 1], [1, 0, 0], [1, 0, 0]]),
        np.array([[0, 0, 1], [-1, 0, 0], [1, 0, 0]]),
    )
    both = np.concatenate([wi, corners[0]]), np.concatenate([wo, corners[1]])
    return both[0].astype(np.float32), both[1].astype(np.float32)


@pytest.fixture(scope="session", params=["smoothstep", "silu7", "silu", "relu"])
def networks(request):
    """An architecture and random parameters whose f spans several orders of magnitude."""
    arch = Architecture(activation=request.param)
    params = init(arch, seed=5)
    params["decoder.3.weight"] = params["decoder.3.weight"] * 8
    params["sampler.2.weight"] = params["sampler.2.weight"] * 10
    return arch, params
