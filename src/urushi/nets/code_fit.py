"""Codes of known values: weighted least squares in the linear basis.

The error of a code is the light that it gets wrong at the probes over the light of the rest:

    sum_p m_p |f_p(c) - f_p| / sum_p m_p f_p,

where m_p is the measure of a probe pair. The lobe does not count: under a smooth interface of an
index below one it has nearly all light, and the rest would hardly matter. Here, values are those of
g (`nets.transmittance`), and T(wi) T(wo) is a factor of the measure.

The error is minimised by reweighted least squares (Lawson 1961): each round solves a quadratic
problem in the logarithm whose weights make it equal to the error at the last code. A weight thus
grows where the exponential would explode. The best code of all rounds is kept. Where a material has
little light, the covariance of the training codes decides.

With two widths, the stretch is estimated from the values first (`log_stretch`).
"""

import functools

import numpy as np

from urushi.core.probe_pairs import probe_pairs
from urushi.core.stretched import rounded
from urushi.core.table import MAX_LOG
from urushi.nets.basis import EMPTY_GAIN, Basis

#: Weight of the measure beside the light, in the first round and in the others.
FIRST_FLOOR, FLOOR = 0.05, 0.02

#: Relative difference below which an error counts as a square, and share of the mean light that is
#: added to f there.
KNEE, DARK = 3e-3, 0.02

#: Share of the prior in the least squares.
PRIOR = 1e-6

#: Rounds of least squares after the first.
ROUNDS = 5

#: Share of the mean of f below which a value counts as this share of it.
LEAST_SHARE = 1e-3

#: [1/sr] Mean rest below which a material has none.
LEAST_REST = 1e-9

#: Codes that are solved at once.
BLOCK = 256

#: Share of the probe pairs from which the stretch is estimated: the first ones, whose half vectors
#: have slopes of all sizes.
SLOPED = 2 / 3

#: Widths of round lobes, whose stretch is one; the last is a Lambertian.
ROUND = 0.02, 0.04, 0.08, 0.15, 0.3, 0.6, 1.2, 1e3

#: Least slope.
LEAST_SLOPE = 1e-4


def solve_codes(
    basis: Basis, rest: np.ndarray, passed: np.ndarray, stretch: np.ndarray | None = None
) -> np.ndarray:
    """Codes float32 (S, K), of two widths (S, K + 1), of values (S, N) [1/sr] at the probe pairs.

    Args:
        rest: g.
        passed: (S, N) T(wi) T(wo) at the probe pairs.
        stretch: (S,) known ln s of two widths; None: it is estimated.
    """
    codes = np.zeros((len(rest), basis.size + basis.widths - 1), np.float32)
    if basis.widths == 2:
        codes[:, -1] = log_stretch(rest, basis.measure) if stretch is None else stretch
    for every, _, own in basis.groups(codes):
        functions = basis.probe_rows(own)
        for start in range(0, len(every), BLOCK):
            rows = every[start : start + BLOCK]
            measure = basis.measure * passed[rows]
            codes[rows, : basis.size] = fitted(functions, measure, basis.prior, rest[rows])
    return codes


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


def fitted(
    rows: np.ndarray, measure: np.ndarray, prior: np.ndarray, rest: np.ndarray
) -> np.ndarray:
    """`solve_codes` at nodes with the functions (N, 1 + K) and this measure (N,) or (S, N)."""
    total = _integral(rest, measure)
    f, light = np.maximum(rest, LEAST_SHARE * total + 1e-12), np.maximum(total, 1e-12)
    functions, logs = rows[:, 1:], np.log(f) - rows[:, 0]
    weights, least = measure * (f / light + FIRST_FLOOR), np.full(len(f), np.inf)
    best = np.zeros((len(f), functions.shape[1]))
    for _ in range(1 + ROUNDS):
        normal = weighted_products(functions, weights) + PRIOR * prior
        right = ((weights * logs) @ functions).astype(np.float64)
        codes = np.linalg.solve(normal, right[..., None])[..., 0]
        error, weights = weighed(rows, measure, f, light, codes)
        better = error < least
        best = np.where(better[:, None], codes, best)
        least = np.where(better, error, least)
    dark = total[:, 0] < LEAST_REST
    best[dark], best[dark, 0] = 0, EMPTY_GAIN
    return best.astype(np.float32)


def _integral(values: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """Integrals (S, 1) of values (S, N)."""
    return np.einsum("sn,sn->s", values, np.broadcast_to(measure, values.shape))[:, None]


def form_about(
    rows: np.ndarray, measure: np.ndarray, prior: np.ndarray, code: np.ndarray
) -> np.ndarray:
    """The matrix (K, K) of the least squares whose solution is a code (K,).

    rows: (N, 1 + K) the functions at the probe pairs, with the measure (N,).
    """
    functions, codes = rows[:, 1:], code[None].astype(np.float32)
    f = np.exp(np.minimum(codes @ functions.T + rows[:, 0], MAX_LOG))
    light = np.maximum(_integral(f, measure), 1e-12)
    weights = weighed(rows, measure, f, light, codes)[1]
    return (functions.T * weights) @ functions + PRIOR * prior


def weighed(
    rows: np.ndarray, measure: np.ndarray, f: np.ndarray, light: np.ndarray, codes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Errors (S,) of codes (S, K), and the weights (S, N) of the next least squares."""
    logs = np.minimum(codes @ rows[:, 1:].T + rows[:, 0], MAX_LOG)
    size, weights = error_slopes(logs, f, light)
    return (_integral(size, measure) / light)[:, 0], measure * weights


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


def weighted_products(x: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Sums float64 (S, K, K) over n of the products x_nk x_nl of x (N, K) by weights (S, N)."""
    count = x.shape[1]
    rows, columns = np.triu_indices(count)  # half of all products
    half = weights @ (x[:, rows] * x[:, columns])
    result = np.empty((len(half), count, count))
    result[:, rows, columns] = result[:, columns, rows] = half
    return result
