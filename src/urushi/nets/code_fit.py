"""Codes of known values: weighted least squares in the linear basis.

The error of a code is its error E, the light that it gets wrong at the probes over all light:

    sum_p m_p |f_p(c) - f_p| / sum_p m_p F_p,

where m_p is the measure of a probe pair, f the light of the rest and F all light, with the lobe. It
is minimised by reweighted least squares (Lawson 1961): each round solves a quadratic problem in the
logarithm whose weights make it equal to the error at the last code. A weight so grows where the
exponential would explode. The best code of all rounds is kept. Where a material has little light,
the covariance of the training codes decides.
"""

import numpy as np

from urushi.core.table import MAX_LOG
from urushi.nets.basis import EMPTY_GAIN, Basis

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


def solve_codes(basis: Basis, rest: np.ndarray, top: np.ndarray) -> np.ndarray:
    """Codes float32 (S, K) of materials whose rests and lobes have the values rest, top (S, N)
    [1/sr] at the probe pairs."""
    codes = np.empty((len(rest), basis.count), np.float32)
    for start in range(0, len(rest), BLOCK):
        rows = slice(start, start + BLOCK)
        codes[rows] = fitted(
            basis.probe_rows, basis.measure, basis.prior, rest[rows], top[rows], rounds=ROUNDS
        )
    return codes


def fitted(
    rows: np.ndarray,
    measure: np.ndarray,
    prior: np.ndarray,
    rest: np.ndarray,
    top: np.ndarray,
    rounds: int = ROUNDS,
) -> np.ndarray:
    """`solve_codes` at nodes with the functions (N, 1 + K) and this measure (N,)."""
    mean = rest @ measure
    f = np.maximum(rest, LEAST_SHARE * mean[:, None] + 1e-12)
    light = np.maximum(mean + top @ measure, 1e-12)[:, None]
    functions, logs = rows[:, 1:], np.log(f) - rows[:, 0]
    shares = measure / light
    codes = _solved(functions, logs, shares * f + FIRST_FLOOR * measure, prior)
    best, least = codes, np.full(len(f), np.inf)
    for turn in range(rounds + 1):
        off = np.minimum(codes @ functions.T + rows[:, 0], MAX_LOG)
        found = np.exp(off)
        off -= rows[:, 0] + logs
        difference = found - f
        error = np.abs(difference) @ measure / light[:, 0]
        better = error < least
        least = np.where(better, error, least)
        best = np.where(better[:, None], codes, best)
        if turn == rounds:
            break
        near = np.abs(off) < 1e-3
        slope = np.where(near, f, difference / np.where(near, 1, off))
        size = np.abs(difference) + KNEE * (f + DARK * light)
        codes = _solved(functions, logs, shares * slope * slope / size + FLOOR * measure, prior)
    best[mean < LEAST_REST] = 0
    best[mean < LEAST_REST, 0] = EMPTY_GAIN
    return best.astype(np.float32)


def _solved(
    functions: np.ndarray, logs: np.ndarray, weights: np.ndarray, prior: np.ndarray
) -> np.ndarray:
    """Codes (S, K) of least squares for logarithms and weights (S, N)."""
    count = functions.shape[1]
    products = (functions[:, :, None] * functions[:, None]).reshape(len(functions), -1)
    normal = (weights @ products).reshape(-1, count, count).astype(np.float64)
    right = ((weights * logs) @ functions).astype(np.float64)
    return np.linalg.solve(normal + PRIOR * prior, right[..., None])[..., 0]
