"""Networks with random weights."""

import numpy as np
import pytest

from urushi.nets import lobe
from urushi.nets.architecture import SCALE, Architecture, init


@pytest.fixture(scope="session", params=["silu7", "relu"])
def networks(request):
    """An architecture and random parameters whose f spans several orders of magnitude.

    Of the shipped activation and of the one with a kink; all have tests of their own.
    """
    arch = Architecture(latent=24, activation=request.param)
    params = init(arch, seed=5)
    params["decoder.3.weight"] = params["decoder.3.weight"] * 8
    params["sampler.2.weight"] = params["sampler.2.weight"] * 10
    return arch, params


@pytest.fixture(scope="session")
def small():
    """The same for networks of about the shipped size."""
    arch = Architecture(
        latent=24, decoder=(24, 24), layerer=(64, 64, 64), encoder=(64, 64), sampler=(16,),
        lobes=1,
    )  # fmt: skip
    params = init(arch, seed=5)
    rng = np.random.default_rng(6)
    params[SCALE] = 0.3 * rng.standard_normal(params[SCALE].shape).astype(np.float32)
    params["decoder.2.weight"] = params["decoder.2.weight"] * 3
    params["sampler.1.weight"] = params["sampler.1.weight"] * 10
    params["layerer.3.weight"] = params["layerer.3.weight"] * 10
    return arch, params


@pytest.fixture(scope="session")
def random_lobes():
    """From a number N and a generator: lobes (N, 6) of all kinds in double precision.

    Dielectrics of eta in [0.5, 3], metals by Fresnel's equations and by Schlick's, and none.
    """

    def draw(count: int, rng: np.random.Generator) -> np.ndarray:
        alpha = 0.01 ** rng.random(count)
        eta, none = rng.uniform(0.5, 3, count), np.zeros(count)
        kinds = [
            lobe.of_coat(alpha, eta),
            np.stack([alpha, none, none, none + 1, eta, rng.uniform(0, 8, count)], axis=-1),
            np.stack([alpha, rng.random(count), none + 1, none, none + 1.5, none], axis=-1),
            np.tile(np.array(lobe.NO_LOBE), (count, 1)),
        ]
        return np.choose(rng.integers(4, size=count)[:, None], kinds)

    return draw


@pytest.fixture(scope="session")
def draw_codes(random_lobes):
    """From a number N and a generator: codes (N, 24) with such lobes, in double precision."""

    def draw(count: int, rng: np.random.Generator) -> np.ndarray:
        return np.concatenate([random_lobes(count, rng), rng.normal(size=(count, 18))], axis=-1)

    return draw
