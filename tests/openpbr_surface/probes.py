"""What tests of `openpbr` share: materials, directions, values and their error."""

import mitsuba as mi
import numpy as np
from tests.directions import at_cosines
from tests.mitsuba.probes import evaluated

from urushi.core.direction_sets import cosine_pairs

WHITE = (1.0, 1.0, 1.0)
WALKS = {"reference": True, "energy_compensation": False}


def loaded(**parameters) -> "mi.BSDF":
    """The plugin; tuples are colours."""
    given = {
        name: {"type": "rgb", "value": list(x)} if isinstance(x, tuple) else x
        for name, x in parameters.items()
    }
    return mi.load_dict({"type": "openpbr", **given})


def pairs(count: int, seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Directions (count, 3) of cosine density above the horizon."""
    return cosine_pairs(np.random.default_rng(seed), count, lowest_cosine=0.02)


def anywhere(count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (count, 3) on the sphere, none near the horizon."""
    w = np.random.default_rng(seed).normal(size=(2, 2 * count, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    return tuple(x[np.abs(x[:, 2]) > 0.1][:count] for x in w)


def toward(cosine: float, degrees: float | np.ndarray = 36.87) -> np.ndarray:
    """Directions (3,) or (N, 3) of a cosine to the normal and of azimuths."""
    return at_cosines(cosine, np.radians(degrees))


def values(bsdf, wi, wo, repeats: int = 1) -> np.ndarray:
    """f (N, C) [1/sr], the mean over evaluations that draw other random numbers."""
    wi, wo = (np.tile(w, (repeats, 1)) for w in (wi, wo))
    return evaluated(bsdf, wi, wo)[0].reshape(repeats, len(wi) // repeats, -1).mean(0)


def error(found: np.ndarray, expected: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """Sum of the absolute deviations of f over the sum of f, by cosines."""
    weight = (wi[:, 2] * wo[:, 2])[:, None]
    return (np.abs(found - expected) * weight).sum() / (expected * weight).sum()
