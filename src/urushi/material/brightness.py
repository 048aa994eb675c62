"""How bright codes are, from measuring a few of them: so that mip levels keep the light.

The gain of a code is a logarithm, and its average is a geometric mean: a level of plain averages is
darker than what it stands for. Its codes' gain is therefore chosen such that every texel reflects,
under light from all sides, what those below it do on average.
"""

from collections.abc import Callable

import numpy as np

from urushi.material import energy, regression
from urushi.material.cores import fill
from urushi.nets.weights import Model

#: Codes that are measured, half of them texels and half averages of several; the most of these.
SAMPLE, AVERAGED = 1024, 16

#: A code's numbers vary by more than this if they mean anything.
LEAST_SPREAD = 1e-4

#: Brightness (n,) of codes (n, size): ln of their hemispherical albedo, but for the gain.
Brightness = Callable[[np.ndarray], np.ndarray]


def fitted(model: Model, read: Callable[[np.ndarray], np.ndarray], count: int) -> Brightness | None:
    """A regression of brightness on codes; None for networks whose codes have no gain.

    read: codes (n, size) by their indices below `count`. The seed is fixed.
    """
    if not model.networks.scalable:
        return None
    rng = np.random.default_rng(0)
    half = SAMPLE // 2
    single = read(rng.integers(count, size=half))
    several = read(rng.integers(count, size=half * AVERAGED)).reshape(half, AVERAGED, -1)
    share = rng.dirichlet(np.full(AVERAGED, 0.3), half).astype(np.float32)
    z = np.concatenate([single, (share[..., None] * several).sum(axis=1)])
    target = np.log(np.maximum(hemispherical(model, z), energy.BLACK)) - z[:, 0]
    mean, scale = regression.standard(z[:, 1:], LEAST_SPREAD)
    everywhere = np.full_like(mean, np.inf)
    even = np.ones_like(target)
    estimate = regression.fitted(z[:, 1:], target, even, mean, scale, everywhere, rng)

    def brightness(codes: np.ndarray) -> np.ndarray:
        result = np.empty((len(codes), 1), np.float32)
        fill(result, lambda part: estimate(part[:, 1:])[:, None], codes)
        return result[:, 0]

    return brightness


def hemispherical(model: Model, z: np.ndarray) -> np.ndarray:
    """Hemispherical albedos (n,) of codes (n, size): reflected light over light from all sides."""
    cosines = energy.rule().cosines
    weights = np.abs(np.gradient(cosines)) * cosines
    return energy.albedo(model, z) @ (weights / weights.sum())
