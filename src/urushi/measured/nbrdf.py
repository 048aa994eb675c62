"""Neural BRDFs: one network of 675 weights for each material (Sztrajman et al. 2021).

Rusinkiewicz's half and difference vectors, as six numbers, pass two hidden layers of 21 ReLU; RGB
is exp(x) - 1, cut at zero. Training is in `urushi.train.nbrdf`.
"""

from dataclasses import dataclass
from types import ModuleType
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi.errors import ParameterError
from urushi.measured.hemisphere import evaluate
from urushi.measured.rusinkiewicz import half_difference_angles

#: Shapes of the weights and biases, in the order in which they lie in one row.
SHAPES = (6, 21), (21,), (21, 21), (21,), (21, 3), (3,)

#: How many numbers a material has.
SIZE = sum(int(np.prod(shape)) for shape in SHAPES)


@dataclass(frozen=True, eq=False)
class Nbrdf:
    """A BRDF given by a network of its own.

    Attributes:
        weights: (675,) numbers in the order of `SHAPES`.
    """

    weights: np.ndarray

    def __post_init__(self) -> None:
        weights = np.array(self.weights, np.float64)
        if weights.shape != (SIZE,) or not np.isfinite(weights).all():
            raise ParameterError(
                f"a neural BRDF has {SIZE} finite weights; these have shape {weights.shape}"
            )
        weights.flags.writeable = False
        object.__setattr__(self, "weights", weights)

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo, width=21)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return np.maximum(np.expm1(logits(self.weights, inputs(wi, wo))), 0)


def inputs(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """What the network sees of unit vectors (N, 3) above the horizon: h and d, (N, 6) float64.

    h lies at the azimuth 0; d's azimuth is taken modulo pi, so that f is reciprocal.
    """
    return vectors(*half_difference_angles(wi.astype(np.float64), wo.astype(np.float64)))


def vectors(theta_h: np.ndarray, theta_d: np.ndarray, phi_d: np.ndarray) -> np.ndarray:
    """h and d, (N, 6), of Rusinkiewicz's angles (N,) [rad]."""
    sin_d = np.sin(theta_d)
    parts = [np.sin(theta_h), np.zeros_like(theta_h), np.cos(theta_h)]
    parts += [sin_d * np.cos(phi_d), sin_d * np.sin(phi_d), np.cos(theta_d)]
    return np.stack(parts, axis=1)


def logits(weights: Any, x: Any, xp: ModuleType = np) -> Any:
    """ln(1 + f) by channel (N, 3), of weights (675,) and inputs (N, 6), with NumPy or JAX."""
    start = 0
    for i, shape in enumerate(SHAPES):
        size = int(np.prod(shape))
        part = weights[start : start + size].reshape(shape)
        start += size
        if len(shape) == 2:
            x = x @ part
        else:
            x = x + part
            x = x if i == len(SHAPES) - 1 else xp.maximum(x, 0)
    return x
