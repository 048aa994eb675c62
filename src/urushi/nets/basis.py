"""The linear basis: f of a code without its lobe, by functions over directions.

The logarithm of f without the topmost lobe is

    ln f(wi, wo) = b(x) + sum_k c_k U_k(x),

where x are the coordinates of `urushi.core.table`. The mean b and the functions U_k are tables that
all materials share. They were fitted to thousands of materials, computed by light transport. The
numbers c_k are the code of a material. They are found by least squares and are unique. The first
function is one, so that c_0 is a logarithmic gain.

The functions of a pair are one row (..., 1 + K): b, then the U_k. All that depends on the code is
the product of such rows with codes.
"""

from typing import NamedTuple

import numpy as np

from urushi.core.probe_pairs import probe_pairs
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, corners, pair_coordinates
from urushi.parallel import fill_blocks

#: Gain with which any code has f = exp(`MIN_LOG`).
EMPTY_GAIN = -100.0


class Basis(NamedTuple):
    """Mean and functions as tables, and what codes are solved with."""

    rows: np.ndarray  # float32 (P, 1 + K), at the nodes of `core.table`
    measure: np.ndarray  # float32 (N,) share of each probe pair in integrals over pairs
    prior: np.ndarray  # (K, K) inverse covariance of the codes of the training materials
    probe_rows: np.ndarray  # float32 (N, 1 + K), at the probe pairs

    @classmethod
    def of(cls, rows: np.ndarray, measure: np.ndarray, prior: np.ndarray) -> "Basis":
        """The basis whose functions have these rows at the nodes."""
        own = cls(rows, measure, prior.astype(np.float64), rows[:0])
        return own._replace(probe_rows=own.at(*own.pairs()))

    @property
    def size(self) -> int:
        """The number of functions, K."""
        return self.rows.shape[1] - 1

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (N, 3)."""
        return probe_pairs(len(self.measure))

    def at(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The functions float32 (..., 1 + K) at pairs (..., 3) above the horizon."""
        wi, wo = np.broadcast_arrays(wi, wo)
        result = np.empty((wi[..., 0].size, self.size + 1), np.float32)
        fill_blocks(result, self._at, wi.reshape(-1, 3), wo.reshape(-1, 3))
        return result.reshape(*wi.shape[:-1], self.size + 1)

    def _at(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        places = pair_coordinates(wi, wo)
        total = np.zeros((len(wi), self.size + 1), np.float32)
        for nodes, share in corners(SHAPE, *places):
            total += self.rows.take(nodes, axis=0) * share[:, None]
        return total


def grid_of(rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The fixed-point grid of 16 bits of each column of rows (P, 1 + K): lowest values and steps.

    Steps are powers of two, so that numbers of the grid are exact in single precision.
    """
    rows = np.asarray(rows, np.float64)
    low, high = rows.min(axis=0), rows.max(axis=0)
    step = np.exp2(np.ceil(np.log2(np.maximum(high - low, 1e-12) / 65534)))
    return np.rint(low / step) * step, step


def on_grid(rows: np.ndarray) -> np.ndarray:
    """Rows float32 (P, 1 + K), rounded to their grid, where they stay the same."""
    while True:  # rounded rows may have a wider range, and so a coarser grid
        step = grid_of(rows)[1]
        rounded = (np.rint(rows / step) * step + 0.0).astype(np.float32)  # zeros are positive
        if np.array_equal(rounded, rows):
            return rounded
        rows = rounded


def decode(z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """f (...) [1/sr] of codes z (..., K) at the functions (..., 1 + K) of pairs; they broadcast."""
    return np.exp(decode_log(z, rows))


def decode_log(z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """ln f (...) of codes z (..., K) at the functions (..., 1 + K) of pairs; they broadcast."""
    if rows.ndim == 2 and z.ndim >= 2 and z.shape[-2] == 1:  # all codes at all pairs
        logs = z[..., 0, :] @ rows[:, 1:].T
    else:
        logs = np.einsum("...k,...k->...", z, rows[..., 1:])
    return np.clip(rows[..., 0] + logs, MIN_LOG, MAX_LOG)


def scaled(z: np.ndarray, factor: np.ndarray) -> np.ndarray:
    """The codes (..., K) of `factor` (...) > 0 times the f of codes z (..., K)."""
    gain = z[..., :1] + np.log(factor)[..., None]
    return np.concatenate(
        [gain, np.broadcast_to(z[..., 1:], (*gain.shape[:-1], z.shape[-1] - 1))], -1
    )
