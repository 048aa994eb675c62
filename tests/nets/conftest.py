"""Random lobes and codes."""

import numpy as np
import pytest

from urushi.nets import lobe


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
