"""The linear basis of two GGX widths: the basis of one width, stretched, and more functions.

The logarithm of f without the topmost lobe is

    ln f(wi, wo) = b(x) + sum_k c_k A_k U_k(x),

where x are the stretched coordinates of `urushi.core.stretched`. The mean and the first functions
are those of one width, with A_k = 1, so that its codes are codes of two widths. The others are
multiplied by factors of the azimuth. The logarithm of the stretch is the last number of a code,
after the c_k.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.core.namespace import NUMPY
from urushi.core.probe_pairs import probe_pairs
from urushi.core.stretched import FACTORS, components_of, features_of, rounded, stretched
from urushi.core.table import SHAPE, corners
from urushi.parallel import fill_blocks

#: Share of the probe pairs that tell the stretch: pairs whose half vectors have slopes of all
#: sizes. `probe_pairs` begins with them.
SLOPED = 2 / 3

#: Widths of round lobes, whose stretch is one; the last is a Lambertian.
ROUND = 0.02, 0.04, 0.08, 0.15, 0.3, 0.6, 1.2, 1e3

#: Least slope.
LEAST_SLOPE = 1e-4


class StretchedBasis(NamedTuple):
    """Mean and functions as tables, and what codes are solved with."""

    rows: np.ndarray  # float32 (P, 1 + K), at the nodes of `core.table` for one width
    factors: np.ndarray  # (1 + K,) the factor of each function; 0: none
    measure: np.ndarray  # float32 (N,) share of each probe pair in integrals over pairs
    prior: np.ndarray  # (K, K) inverse covariance of the codes of the training materials

    @property
    def size(self) -> int:
        """The number of functions, K."""
        return self.rows.shape[1] - 1

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (N, 3)."""
        return probe_pairs(len(self.measure), 2)

    def at(self, features: np.ndarray, log_stretch: float) -> np.ndarray:
        """The functions float32 (N, 1 + K) times their factors at `features_of` pairs (N, 6)."""
        result = np.empty((len(features), self.size + 1), np.float32)
        fill_blocks(result, functools.partial(self._at, float(np.exp(2 * log_stretch))), features)
        return result

    def _at(self, stretch2: float, features: np.ndarray) -> np.ndarray:
        both, apart = components_of(features.astype(np.float64))
        places, around = stretched(both, apart, stretch2, NUMPY)
        total = np.zeros((len(features), self.size + 1), np.float32)
        for nodes, share in corners(SHAPE, *places):
            total += self.rows.take(nodes, axis=0) * share[:, None]
        every = np.stack([np.ones(len(features)), *around], axis=-1).astype(np.float32)
        return total * every[:, self.factors]

    def contracted(self, codes: np.ndarray) -> np.ndarray:
        """Tables float32 (*`SHAPE`, C, 1 + `FACTORS`) of codes (C, K + 1).

        ln f is their sum over the last axis, each times its factor, at stretched coordinates.
        """
        numbers = np.concatenate([np.ones((len(codes), 1)), codes[:, :-1]], axis=1)
        of_factor = self.factors == np.arange(1 + FACTORS)[:, None]
        weights = numbers[:, None] * of_factor  # (C, 1 + FACTORS, 1 + K)
        table = self.rows @ weights.reshape(-1, self.size + 1).T
        return table.reshape(*SHAPE, len(codes), -1).astype(np.float32)

    def probe_rows(self, log_stretch: float) -> np.ndarray:
        """The functions (N, 1 + K) at the probe pairs."""
        return self.at(features_of(*self.pairs()), log_stretch)


def log_stretch(rest: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """ln s (S,) of rests with values (S, N) [1/sr] at the probe pairs of this measure (N,).

    For a lobe of the widths a_u, a_v, the slopes t of half vectors have the mean
    ln(t_v / t_u) = ln(a_v / a_u) in any measure that is a function of f. It is the mean of f^2, to
    which diffuse light hardly contributes.
    """
    shares, contrast = slopes_of(len(measure), measure.astype(np.float32).tobytes())
    f2 = np.square(rest[:, : len(shares)], dtype=np.float64)
    mean = (f2 @ (shares * contrast)) / np.maximum(f2 @ shares, 1e-30)
    return rounded(0.5 * mean).astype(np.float32)


@functools.lru_cache(maxsize=4)
def slopes_of(count: int, measure: bytes) -> tuple[np.ndarray, np.ndarray]:
    """Shares (M,) of the first probe pairs, and ln(t_v / t_u) (M,) of their half vectors.

    measure: float32 (count,) of all of them. It is changed as little as possible so that round
    lobes (`ROUND`) have a mean of zero.
    """
    wi, wo = (w[: round(count * SLOPED)].astype(np.float64) for w in probe_pairs(count, 2))
    shares = np.frombuffer(measure, np.float32)[: len(wi)].astype(np.float64)
    half = np.abs(wi + wo)
    x, y = (half[:, k] / half[:, 2] + LEAST_SLOPE for k in (0, 1))
    contrast, difference = np.log(y / x), 2 - np.linalg.norm(wi + wo, axis=1)
    lobes = [(1 + (x * x + y * y) / a**2) ** -4 * difference**k for a in ROUND for k in (0, 1, 2)]
    means = np.stack(lobes) * shares
    means /= np.linalg.norm(means, axis=1, keepdims=True)
    change = np.linalg.lstsq(means * contrast, -means @ contrast, rcond=1e-3)[0]
    return shares * np.maximum(1 + change, 0), contrast
