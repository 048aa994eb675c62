"""The linear basis: f of a code without its lobe, by functions over directions.

f without the topmost lobe is T(wi) T(wo) g(wi, wo), with T of `nets.transmittance`, and

    ln g(wi, wo) = b(x) + sum_k c_k A_k U_k(x),

where x are the coordinates of `urushi.core.table`. The mean b and the functions U_k are tables that
all materials share. They were fitted to thousands of materials, computed by light transport. The
numbers c_k are the code of a material. They are found by least squares and are unique. The first
function is one, so that c_0 is a logarithmic gain.

With one GGX width, A_k is 1. With two, x are the stretched coordinates of `urushi.core.stretched`,
and A_k is 1 or a factor of the azimuth. The mean and the first functions are those of one width, so
that its codes are codes of two widths. The logarithm of the stretch, ln s, is the last number of a
code, after the c_k.

The functions of a pair are one row (..., 1 + K): b, then the A_k U_k. All that depends on the c_k
is the product of such rows with codes.
"""

import functools
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from urushi.core.namespace import NUMPY, Components
from urushi.core.probe_pairs import probe_pairs
from urushi.core.stretched import FACTORS, stretched
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, coordinates, corners
from urushi.parallel import fill_blocks

#: Gain with which any code has g = exp(`MIN_LOG`).
EMPTY_GAIN = -100.0

#: Stretches whose functions at the same pairs are kept.
KEPT = 16


class Functions(NamedTuple):
    """The functions (..., 1 + K) of some pairs, from ln s."""

    wi: np.ndarray  # (..., 3)
    wo: np.ndarray
    at: Callable[[float], np.ndarray]

    def __call__(self, log_stretch: float) -> np.ndarray:
        return self.at(log_stretch)


@dataclass(frozen=True, eq=False)
class Basis:
    """Mean and functions as tables, and what codes are solved with."""

    rows: np.ndarray  # float32 (P, 1 + K), at the nodes of `core.table`
    factors: np.ndarray  # (1 + K,) which of the factors of `core.stretched` is A_k; 0: one
    measure: np.ndarray  # float32 (N,) share of each probe pair in integrals over pairs
    prior: np.ndarray  # (K, K) inverse covariance of the codes of the training materials
    widths: int = 1  # GGX widths of a surface

    @property
    def size(self) -> int:
        """The number of functions, K."""
        return self.rows.shape[1] - 1

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (N, 3)."""
        return probe_pairs(len(self.measure), self.widths)

    @functools.cached_property
    def probe_rows(self) -> Functions:
        """The functions (N, 1 + K) at the probe pairs."""
        return self.functions_at(*self.pairs())

    @functools.cached_property
    def norm(self) -> np.ndarray:
        """The matrix N (L, L) by which a difference d of codes (L,) has the size |d N|.

        It is the root mean square of the difference of ln g at the probe pairs, by their measure.
        With two widths, that of the stretches is added.
        """
        shares = self.measure / self.measure.sum()
        functions = self.probe_rows(0.0)[:, 1:] * np.sqrt(shares)[:, None]
        result = np.eye(self.size + self.widths - 1)
        result[: self.size, : self.size] = np.linalg.cholesky(functions.T @ functions)
        return result

    def functions_at(self, wi: np.ndarray, wo: np.ndarray) -> Functions:
        """The functions at pairs (..., 3) above the horizon, which are kept for some ln s."""
        return Functions(wi, wo, functools.lru_cache(KEPT)(functools.partial(self.at, wi, wo)))

    def at(self, wi: np.ndarray, wo: np.ndarray, log_stretch: float = 0.0) -> np.ndarray:
        """The functions float32 (..., 1 + K) at pairs (..., 3) above the horizon."""
        wi, wo = np.broadcast_arrays(wi, wo)
        result = np.empty((wi[..., 0].size, self.size + 1), np.float32)
        at = functools.partial(self._at, float(np.exp(2 * log_stretch)))
        rows = fill_blocks(result, at, wi.reshape(-1, 3), wo.reshape(-1, 3))
        return rows.reshape(*wi.shape[:-1], self.size + 1)

    def _at(self, stretch2: float, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        both, apart = (Components(*w.T.astype(np.float64)) for w in (wi + wo, wi - wo))
        if self.widths == 1:
            places, around = coordinates(both, apart, NUMPY), ()
        else:
            places, around = stretched(both, apart, stretch2, NUMPY)
        total = np.zeros((len(wi), self.size + 1), np.float32)
        for nodes, share in corners(SHAPE, *places):
            total += self.rows.take(nodes, axis=0) * share[:, None]
        if around:
            every = np.stack([np.ones(len(wi)), *around], axis=-1).astype(np.float32)
            total *= every[:, self.factors]
        return total

    def split(self, codes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The numbers (..., K) of codes, and their ln s (...), zero for one width."""
        if self.widths == 2:
            return codes[..., :-1], codes[..., -1]
        return codes, np.zeros(codes.shape[:-1], np.float32)

    def groups(self, codes: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, float]]:
        """Places and numbers (M, K) of those codes (S, ...) that share a stretch, and its ln s."""
        numbers, stretch = self.split(codes)
        for own in np.unique(stretch):
            rows = np.flatnonzero(stretch == own)
            yield rows, numbers[rows], float(own)

    def table(self, codes: np.ndarray) -> np.ndarray:
        """ln g of codes (C, ...) at the nodes: float32 (*`SHAPE`, C).

        With two widths (*`SHAPE`, C, 1 + `FACTORS`): ln g is the sum over the last axis, each times
        its factor, at stretched coordinates.
        """
        numbers, _ = self.split(codes)
        if self.widths == 1:
            return decode_log(numbers[:, None], self.rows).T.reshape(*SHAPE, len(codes))
        numbers = np.concatenate([np.ones((len(codes), 1)), numbers], axis=1)
        of_factor = self.factors == np.arange(1 + FACTORS)[:, None]
        weights = numbers[:, None] * of_factor  # (C, 1 + FACTORS, 1 + K)
        table = self.rows @ weights.reshape(-1, self.size + 1).T
        return table.reshape(*SHAPE, len(codes), -1).astype(np.float32)


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
    """g (...) [1/sr] of numbers z (..., K) at the functions (..., 1 + K) of pairs; they
    broadcast."""
    return np.exp(decode_log(z, rows))


def decode_log(z: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """ln g (...) of numbers z (..., K) at the functions (..., 1 + K) of pairs; they broadcast."""
    if rows.ndim == 2 and z.ndim >= 2 and z.shape[-2] == 1:  # all codes at all pairs
        logs = z[..., 0, :] @ rows[:, 1:].T
    else:
        logs = np.einsum("...k,...k->...", z, rows[..., 1:])
    return np.clip(rows[..., 0] + logs, MIN_LOG, MAX_LOG)
