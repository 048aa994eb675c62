"""Fit of the analytic lobe to a BRDF that is given by values.

A BRDF is approximated by a diffuse term and one GGX lobe with Schlick's Fresnel term,

    f ~ diffuse / pi + (normal (1 - m) + grazing m) S(alpha),    m = (1 - c)^5,

where S is `lobe.shape` and c the cosine to the facet. Errors are relative to f. The rest of the
BRDF, f minus the lobe, should not be negative. Errors where the sum
is above f therefore have a much larger weight than errors below f. Large errors below f, which one
lobe cannot represent, enter linearly (Huber 1964).

The best width on a grid, by weighted least squares, is the initial guess of a Gauss-Newton fit of
all four unknowns. A lobe of an anisotropic BRDF has two widths, and the fit five unknowns.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes

#: Widths of the grid.
GRID = np.exp(np.linspace(np.log(MIN_ALPHA), 0.0, 24))

#: [1/sr] Added to f in relative errors.
DARK = 1e-3

#: Factor on the square of an error where the approximation is above f.
OVERSHOOT_WEIGHT = 30.0

#: Relative error below f from which errors count linearly.
KNEE = 0.05

#: Greatest number of steps, and change of every unknown below which there are no more.
STEPS, CONVERGED = 14, 1e-4

#: Geometric means and quotients of two widths in the grid of anisotropic lobes.
MEANS = np.exp(np.linspace(np.log(MIN_ALPHA), 0.0, 14))
QUOTIENTS = np.exp(np.log(8.0) * np.linspace(-1.0, 1.0, 7))

#: Bounds of the diffuse term and the factors. Bounds of the logarithms of widths follow them.
_LOWER, _UPPER = [0.0, 0.0, 0.0], [np.inf, 1.0, 1.0]

#: Greatest change of ln alpha in a step, and number of last steps that keep alpha.
LONGEST_STEP, LAST_STEPS = 0.3, 3

#: Number of unknowns before the logarithms of widths.
_LINEAR = 3

#: Entries of a symmetric 3 x 3 matrix.
_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))

#: BRDFs that are fitted at once, so that their arrays stay in a core's cache.
BLOCK = 512


def fit_lobes(f: np.ndarray, widths: int = 1) -> np.ndarray:
    """Return the lobes float32 (..., N) of BRDFs with values f (..., P) [1/sr] at the probe pairs.

    These are `probe_pairs(P, widths)`. N is 6 for lobes of one width and 7 for lobes of two. The
    factors of Schlick's term are in [0, 1], the other numbers equal `lobe.NO_LOBE`. A BRDF
    without a lobe has the factors 0.
    """
    values = np.ascontiguousarray(f, np.float64)  # the order of sums follows the layout
    rows = np.maximum(values.reshape(-1, values.shape[-1]), 0.0)
    result = np.empty((len(rows), len(lobes.NUMBERS[widths])), np.float32)
    for start in range(0, len(rows), BLOCK):
        place = slice(start, start + BLOCK)
        result[place] = _fit(rows[place], widths)
    return result.reshape(*values.shape[:-1], result.shape[-1])


class _Grid(NamedTuple):
    """Precomputed quantities at P pairs, from `schlick` on in single precision, for the steps."""

    logs: np.ndarray  # (A, W) logarithms of the grid's widths
    columns: np.ndarray  # (P, 3 A) the diffuse term and the lobe's two, for factors of one
    products: np.ndarray  # (P, 6 A) of two columns, by `_PAIRS`
    schlick: np.ndarray  # (2, P) 1 - (1 - c)^5 and (1 - c)^5
    cos: np.ndarray  # (2, P) cosines of either direction
    half2: np.ndarray  # (3, P) squared components of wi + wo
    sides2: np.ndarray  # (2, 2, P) squared x and y of wi, and of wo


@functools.cache
def _grid(probes: int, widths: int) -> _Grid:
    wi, wo = (w.astype(np.float64) for w in probe_pairs(probes, widths))
    fifth = (1.0 - lobes.cosine_to_facet(wi, wo)) ** 5
    if widths == 1:
        alphas = GRID[:, None]
        shapes = lobes.shape(GRID, wi[:, None], wo[:, None])
    else:
        roots = np.sqrt(QUOTIENTS)
        both = np.stack([np.outer(MEANS, roots), np.outer(MEANS, 1 / roots)], axis=-1)
        alphas = np.unique(np.clip(both.reshape(-1, 2), MIN_ALPHA, 1.0), axis=0)
        shapes = lobes.shape(Widths(*alphas.T), wi[:, None], wo[:, None])
    white = np.full_like(shapes, 1 / np.pi)
    columns = np.stack([white, shapes * (1 - fifth)[:, None], shapes * fifth[:, None]], axis=1)
    products = np.stack([columns[:, i] * columns[:, j] for i, j in _PAIRS], axis=1)
    single = (
        np.stack([1 - fifth, fifth]),
        np.stack([wi[:, 2], wo[:, 2]]),
        (wi + wo).T ** 2,
        np.stack([wi[:, :2].T, wo[:, :2].T]) ** 2,
    )
    return _Grid(
        np.log(alphas),
        columns.reshape(probes, -1),
        products.reshape(probes, -1),
        *(array.astype(np.float32) for array in single),
    )


def _fit(f: np.ndarray, widths: int) -> np.ndarray:
    """`fit_lobes` for f (N, P)."""
    # Sums over some rows and over many differ by rounding: in single precision they are the same.
    grid, open_rows = _grid(f.shape[-1], widths), np.arange(len(f))
    at = _best_of_grid(f, grid).astype(np.float32)
    scale = (1 / (f + DARK)).astype(np.float32)
    aim = (f / (f + DARK)).astype(np.float32)
    white = scale * np.float32(1 / np.pi)
    longest = np.array([np.inf] * _LINEAR + [LONGEST_STEP] * widths)
    bounds = np.array(_LOWER + [np.log(MIN_ALPHA)] * widths), np.array(_UPPER + [0.0] * widths)
    for step in range(STEPS):
        if step == STEPS - LAST_STEPS:
            longest[_LINEAR:] = 0.0
        x = at[open_rows].astype(np.float64)
        shape, *slopes = _shape(grid, np.exp(x[:, _LINEAR:]).astype(np.float32))
        shape *= scale
        diffuse, normal, grazing = x[:, :3].T[..., None].astype(np.float32)
        # Derivatives of the errors by the unknowns.
        columns = [white, shape * grid.schlick[0], shape * grid.schlick[1], *slopes]
        error = normal * columns[1]
        error += grazing * columns[2]
        for slope in slopes:
            slope *= error
        error += diffuse * white
        error -= aim
        weights = np.where(error > 0, np.float32(OVERSHOOT_WEIGHT), KNEE / np.maximum(-error, KNEE))
        lower, upper = np.maximum(bounds[0] - x, -longest), np.minimum(bounds[1] - x, longest)
        # The step of Gauss and Newton's method, within bounds.
        size, rows = len(columns), len(error)
        curvature, ahead = np.empty((size, size, rows)), np.empty((size, rows))
        for i, column in enumerate(columns):
            weighted = weights * column
            ahead[i] = np.einsum("np,np->n", weighted, error)
            for j in range(i, size):
                curvature[i, j] = curvature[j, i] = np.einsum("np,np->n", weighted, columns[j])
        change = _bounded(curvature, -ahead, lower.T, upper.T).T
        at[open_rows] = x + change
        # A row that has converged is left alone, so that no row affects another.
        moving = (np.abs(change) > CONVERGED).any(axis=-1)
        if not moving.all():
            if not moving.any():
                break
            open_rows, scale, aim, white = (y[moving] for y in (open_rows, scale, aim, white))
    result = np.tile(lobes.no_lobe(widths), (len(f), 1))
    result[:, lobes.WIDTH_PLACES[widths]] = np.exp(at[:, _LINEAR:])
    result[:, 1:3] = at[:, 1:3]
    return result


def _shape(grid: _Grid, alpha: np.ndarray) -> tuple[np.ndarray, ...]:
    """`lobe.shape` (N, P) of widths (N, W), and the W derivatives of its logarithm by theirs."""
    u, v = alpha[:, :1], alpha[:, -1:]
    product = u * v
    x2, y2, z2 = (v / u) * grid.half2[0], (u / v) * grid.half2[1], product * grid.half2[2]
    total = 1 / (x2 + y2 + z2)
    shape = (product * np.float32(1 / np.pi)) * np.square(grid.half2.sum(axis=0) * total)
    slopes = [1 - 2 * (y2 - x2 + z2) * total, 1 - 2 * (x2 - y2 + z2) * total]
    for cos, side2 in zip(grid.cos, grid.sides2, strict=True):
        ahead, aside = (u * u) * side2[0], (v * v) * side2[1]
        root = np.sqrt(ahead + aside + cos * cos)
        masking = root + cos
        shape /= masking
        masking *= root
        slopes[0] -= ahead / masking
        slopes[1] -= aside / masking
    return (shape, sum(slopes)) if alpha.shape[1] == 1 else (shape, *slopes)


def _best_of_grid(f: np.ndarray, grid: _Grid) -> np.ndarray:
    """The best three factors of the grid's best widths, and their logarithms: (N, 3 + W)."""
    weights = 1 / np.square(f + DARK)
    count = len(grid.logs)
    products = (weights @ grid.products).reshape(len(f), len(_PAIRS), count)
    normal = np.empty((3, 3, len(f), count))
    for place, (i, j) in enumerate(_PAIRS):
        normal[i, j] = normal[j, i] = products[:, place]
    slope = ((weights * f) @ grid.columns).reshape(len(f), 3, count).swapaxes(0, 1)
    factors = _bounded(normal, slope, np.zeros_like(slope), np.full_like(slope, np.inf))
    gain = 2 * (factors * slope).sum(axis=0) - (factors * _product(normal, factors)).sum(axis=0)
    best = gain.argmax(axis=-1)
    return np.column_stack([*factors[:, np.arange(len(f)), best], grid.logs[best]])


def _bounded(
    normal: np.ndarray, slope: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Lower x' normal x / 2 - slope' x within bounds (K, ...), which contain zero.

    From the minimum without bounds, unknowns that exceed a bound are fixed there, and the others
    solved again. The result is the minimum in most cases, and never worse than zero.

    normal: (K, K, ...), for problems along the last axes.
    """
    size = len(slope)
    eye = np.eye(size).reshape(size, size, *[1] * (slope.ndim - 1))
    # In units in which the curvature's diagonal is one.
    unit = 1 / np.sqrt(np.einsum("ii...->i...", normal) + 1e-30)
    normal = normal * unit * unit[:, None] + 1e-12 * eye
    slope, lower, upper = slope * unit, lower / unit, upper / unit
    x = _solved(normal, slope)
    fixed = np.zeros(x.shape, bool)
    for _ in range(size - 1):
        outside = (x < lower) | (x > upper)
        if not outside.any():
            return x * unit
        fixed |= outside
        x = np.where(fixed, np.clip(x, lower, upper), 0.0)
        free = ~fixed
        reduced = np.where(free & free[:, None], normal, eye)
        x = _solved(reduced, np.where(fixed, x, slope - _product(normal, x)))
    x = np.clip(x, lower, upper)
    bend = (x * _product(normal, x)).sum(axis=0)
    return x * np.clip((slope * x).sum(axis=0) / np.maximum(bend, 1e-30), 0.0, 1.0) * unit


def _product(matrix: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Products (K, ...) of symmetric matrices (K, K, ...) and vectors (K, ...)."""
    return (matrix * x[:, None]).sum(axis=0)


def _solved(matrix: np.ndarray, right: np.ndarray) -> np.ndarray:
    """Solutions (K, ...) for positive definite matrices (K, K, ...), all at once.

    Gauss's elimination: LAPACK, called for one small matrix after the other, takes ten times as
    long.
    """
    upper, x = matrix.copy(), right.copy()
    for i in range(len(x)):
        for j in range(i + 1, len(x)):
            share = upper[i, j] / upper[i, i]
            upper[j, j:] -= share * upper[i, j:]
            x[j] -= share * x[i]
    for i in reversed(range(len(x))):
        x[i] -= (upper[i, i + 1 :] * x[i + 1 :]).sum(axis=0)
        x[i] /= upper[i, i]
    return x
