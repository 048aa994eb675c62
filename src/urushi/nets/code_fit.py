"""Codes of known values: weighted least squares in the linear basis.

The error of a code is the light that it gets wrong at the probes over the light of the rest:

    sum_p m_p |f_p(c) - f_p| / sum_p m_p f_p,

where m_p is the measure of a probe pair. The lobe does not count: under a smooth interface of an
index below one it has nearly all light, and the rest would hardly matter. The error
is minimised by reweighted least squares (Lawson 1961): each round solves a quadratic problem in the
logarithm whose weights make it equal to the error at the last code. A weight so grows where the
exponential would explode. The best code of all rounds is kept. Where a material has little light,
the covariance of the training codes decides.
"""

import numpy as np

from urushi.core.table import MAX_LOG
from urushi.nets.basis import EMPTY_GAIN, Basis
from urushi.nets.stretched_basis import StretchedBasis

#: Weight of the measure beside the light, in the first round and in the others.
FIRST_FLOOR, FLOOR = 0.05, 0.02

#: Relative difference below which an error counts as a square, and share of the mean light that is
#: added to f there.
KNEE, DARK = 3e-3, 0.02

#: Share of the prior in the least squares.
PRIOR = 1e-6

#: Rounds after the first.
ROUNDS = 5

#: Share of the mean of f below which a value counts as this share of it.
LEAST_SHARE = 1e-3

#: [1/sr] Mean rest below which a material has none.
LEAST_REST = 1e-9

#: Codes that are solved at once.
BLOCK = 256


def solve_codes(basis: Basis, rest: np.ndarray) -> np.ndarray:
    """Codes float32 (S, K) of materials whose rests have the values (S, N) [1/sr] at the probe
    pairs."""
    return _solved_at(basis.probe_rows, basis, rest)


def solve_stretched(basis: StretchedBasis, rest: np.ndarray, stretch: np.ndarray) -> np.ndarray:
    """`solve_codes` (S, K + 1) of two widths for known ln s (S,), the last numbers of the codes."""
    codes = np.empty((len(rest), basis.size + 1), np.float32)
    codes[:, -1] = stretch
    for own in np.unique(codes[:, -1]):
        rows = codes[:, -1] == own
        codes[rows, :-1] = _solved_at(basis.probe_rows(own), basis, rest[rows])
    return codes


def _solved_at(
    functions: np.ndarray, basis: Basis | StretchedBasis, rest: np.ndarray
) -> np.ndarray:
    codes = np.empty((len(rest), basis.size), np.float32)
    for start in range(0, len(rest), BLOCK):
        rows = slice(start, start + BLOCK)
        codes[rows] = fitted(functions, basis.measure, basis.prior, rest[rows])
    return codes


def fitted(
    rows: np.ndarray,
    measure: np.ndarray,
    prior: np.ndarray,
    rest: np.ndarray,
    rounds: int = ROUNDS,
) -> np.ndarray:
    """`solve_codes` at nodes with the functions (N, 1 + K) and this measure (N,)."""
    f, light = bounded(rest, measure), _light(rest, measure)
    functions, logs = rows[:, 1:], np.log(f) - rows[:, 0]
    codes = solved(functions, logs, measure * (f / light + FIRST_FLOOR), prior)
    best, least = codes, np.full(len(f), np.inf)
    for _ in range(rounds):
        error, weights = weighed(rows, measure, f, light, codes)
        better = error < least
        least = np.where(better, error, least)
        best = np.where(better[:, None], codes, best)
        codes = solved(functions, logs, weights, prior)
    error, _ = weighed(rows, measure, f, light, codes)
    best = np.where((error < least)[:, None], codes, best)
    dark = rest @ measure < LEAST_REST
    best[dark], best[dark, 0] = 0, EMPTY_GAIN
    return best.astype(np.float32)


def bounded(rest: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """Rests (S, N), of which no value is far below the mean."""
    return np.maximum(rest, LEAST_SHARE * (rest @ measure)[:, None] + 1e-12)


def _light(rest: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """Light (S, 1) of rests (S, N)."""
    return np.maximum(rest @ measure, 1e-12)[:, None]


def form_about(rows: np.ndarray, basis: Basis | StretchedBasis, codes: np.ndarray) -> np.ndarray:
    """Matrices (S, K, K) of the least squares whose solutions are codes (S, K).

    rows: (N, 1 + K) the functions at the probe pairs.
    """
    f = np.exp(np.minimum(codes @ rows[:, 1:].T + rows[:, 0], MAX_LOG))
    weights = weighed(rows, basis.measure, f, _light(f, basis.measure), codes)[1]
    return normal(rows[:, 1:], weights, basis.prior)


def weighed(
    rows: np.ndarray, measure: np.ndarray, f: np.ndarray, light: np.ndarray, codes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors (S,) of codes (S, K), and the weights (S, N) of the next least squares."""
    logs = np.minimum(codes @ rows[:, 1:].T + rows[:, 0], MAX_LOG)
    size, weights = error_slopes(logs, f, light)
    return size @ measure / light[:, 0], measure * weights


def error_slopes(
    logs: np.ndarray, f: np.ndarray, light: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors of ln f against f (S, ...), and the weights by which squares of logarithms are errors
    over the light (S, 1, ...)."""
    difference, off = np.exp(logs) - f, logs - np.log(f)
    near = np.abs(off) < 1e-3
    slope = np.where(near, f, difference / np.where(near, 1, off))
    size = np.abs(difference)
    return size, slope * slope / (light * (size + KNEE * (f + DARK * light))) + FLOOR


def solved(
    functions: np.ndarray, logs: np.ndarray, weights: np.ndarray, prior: np.ndarray
) -> np.ndarray:
    """Codes (S, K) of least squares for logarithms and weights (S, N)."""
    right = ((weights * logs) @ functions).astype(np.float64)
    return np.linalg.solve(normal(functions, weights, prior), right[..., None])[..., 0]


def normal(functions: np.ndarray, weights: np.ndarray, prior: np.ndarray) -> np.ndarray:
    """The matrices (S, K, K) of the normal equations for weights (S, N)."""
    return weighted_products(functions, weights) + PRIOR * prior


def weighted_products(x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums float64 (S, K, K) over n of the products x_nk x_nl of x (N, K) by weights (S, N)."""
    count = x.shape[1]
    rows, columns = np.triu_indices(count)  # half of all products
    half = weights @ (x[:, rows] * x[:, columns])
    result = np.empty((len(half), count, count))
    result[:, rows, columns] = result[:, columns, rows] = half
    return result
