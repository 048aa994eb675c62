"""The analytic lobe of a BRDF that is known by its values alone.

A BRDF is approximated by a diffuse term and one GGX lobe with Schlick's Fresnel term,

    f ~ diffuse / pi + (normal (1 - m) + grazing m) S(alpha),    m = (1 - c)^5,

where S is `lobe.shape` and c the cosine to the facet. Errors are relative to f. The rest of the
BRDF, f less the lobe, is learned by the networks, and should not be negative: where the sum is
above f, errors count much more than where it is below; and large errors below f, from what one lobe
cannot represent, count linearly (Huber 1964).

The best width of a grid, by weighted least squares, is the start of Gauss and Newton's method for
all four unknowns.
"""

import functools
from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes

#: Widths of the grid.
GRID = np.exp(np.linspace(np.log(MIN_ALPHA), 0.0, 24))

#: [1/sr] Added to f in relative errors.
DARK = 1e-3

#: Factor on the square of an error where the approximation is above f.
OVERSHOOT_WEIGHT = 30.0

#: Relative error below f from which errors count linearly.
KNEE = 0.05

#: Number of steps, and sweeps of coordinate descent in each.
STEPS, SWEEPS = 14, 20

#: Bounds of the diffuse term, the factors and ln alpha.
_LOWER = np.array([0.0, 0.0, 0.0, np.log(MIN_ALPHA)])
_UPPER = np.array([np.inf, 1.0, 1.0, 0.0])

#: Greatest change of ln alpha in a step, and number of last steps that keep alpha.
LONGEST_STEP, LAST_STEPS = 0.3, 3

#: BRDFs that are fitted at once, so that their arrays stay in a core's cache.
BLOCK = 256


def fit_lobes(f: np.ndarray) -> np.ndarray:
    """Return the lobes float32 (..., 6) of BRDFs with values f (..., P) [1/sr] at `probe_pairs(P)`.

    The factors of Schlick's term are in [0, 1], the other numbers those of `lobe.NO_LOBE`. A BRDF
    without a lobe has the factors 0.
    """
    values = np.asarray(f, np.float64)
    rows = np.maximum(values.reshape(-1, values.shape[-1]), 0.0)
    result = np.empty((len(rows), len(lobes.LOBE_NUMBERS)), np.float32)
    for start in range(0, len(rows), BLOCK):
        place = slice(start, start + BLOCK)
        result[place] = _fit(rows[place])
    return result.reshape(*values.shape[:-1], -1)


class _Grid(NamedTuple):
    """The approximation's columns at P pairs for every width.

    Attributes:
        columns: (P, A, 3) the diffuse term and the two of the lobe, for factors of one.
        products: (P, A, 3, 3) of two columns.
        fifth: (P,) Schlick's (1 - c)^5.
    """

    columns: np.ndarray
    products: np.ndarray
    fifth: np.ndarray


@functools.cache
def _grid(probes: int) -> _Grid:
    wi, wo = (w.astype(np.float64) for w in probe_pairs(probes))
    fifth = (1.0 - lobes.cosine_to_facet(wi, wo)) ** 5
    shapes = lobes.shape(GRID, wi[:, None], wo[:, None])
    white = np.full_like(shapes, 1 / np.pi)
    columns = np.stack([white, shapes * (1 - fifth)[:, None], shapes * fifth[:, None]], axis=-1)
    return _Grid(columns, columns[..., :, None] * columns[..., None, :], fifth)


def _fit(f: np.ndarray) -> np.ndarray:
    """`fit_lobes` for f (N, P)."""
    alpha, factors = _best_of_grid(f)
    wi, wo = (w.astype(np.float64) for w in probe_pairs(f.shape[-1]))
    fifth = _grid(f.shape[-1]).fifth
    scale = 1 / (f + DARK)
    for step in range(STEPS):
        shape = lobes.shape(alpha[:, None], wi, wo)
        slope = _shape_slope(alpha[:, None], wi, wo, shape)
        first, second = shape * (1 - fifth), shape * fifth
        reflectance = factors[:, 1, None] * (1 - fifth) + factors[:, 2, None] * fifth
        error = (factors[:, 0, None] / np.pi + shape * reflectance - f) * scale
        weights = np.where(error > 0, OVERSHOOT_WEIGHT, KNEE / np.maximum(-error, KNEE))
        columns = np.stack(
            [scale / np.pi, first * scale, second * scale, slope * reflectance * scale], axis=-2
        )
        weighted = columns * weights[:, None]
        normal = weighted @ np.swapaxes(columns, -1, -2)
        ahead = (weighted @ error[..., None])[..., 0]
        at = np.concatenate([factors, np.log(alpha)[:, None]], axis=-1)
        longest = LONGEST_STEP if step < STEPS - LAST_STEPS else 0.0
        lower = np.maximum(_LOWER - at, [-np.inf, -np.inf, -np.inf, -longest])
        upper = np.minimum(_UPPER - at, [np.inf, np.inf, np.inf, longest])
        at += _bounded(normal, -ahead, lower, upper)
        factors, alpha = at[:, :3], np.exp(at[:, 3])
    result = np.tile(np.array(lobes.NO_LOBE, np.float32), (len(f), 1))
    result[:, 0] = alpha
    result[:, 1:3] = factors[:, 1:]
    return result


def _shape_slope(
    alpha: np.ndarray, wi: np.ndarray, wo: np.ndarray, shape: np.ndarray
) -> np.ndarray:
    """The derivative (...) of `lobe.shape` by ln alpha."""
    step = 1e-4
    return (lobes.shape(alpha * (1 + step), wi, wo) - shape) / step


def _best_of_grid(f: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The width (N,) of the grid with the least error, and its three factors (N, 3)."""
    grid = _grid(f.shape[-1])
    weights = 1 / np.square(f + DARK)
    probes, count = grid.columns.shape[:2]
    normal = (weights @ grid.products.reshape(probes, -1)).reshape(-1, count, 3, 3)
    slope = ((weights * f) @ grid.columns.reshape(probes, -1)).reshape(-1, count, 3)
    zero = np.zeros_like(slope)
    factors = _bounded(normal, slope, zero, zero + np.inf)
    gain = 2 * (factors * slope).sum(-1) - np.einsum("nai,naij,naj->na", factors, normal, factors)
    best = gain.argmax(axis=-1)
    return GRID[best], factors[np.arange(len(f)), best]


def _bounded(
    normal: np.ndarray, slope: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """Minimise x' normal x / 2 - slope' x within bounds (..., K).

    By coordinate descent from the minimum without bounds, which is exact where it is within them,
    or from zero, which must be within the bounds.
    """
    # In units in which the curvature's diagonal is one.
    unit = 1 / np.sqrt(np.einsum("...ii->...i", normal) + 1e-30)
    scaled = normal * unit[..., :, None] * unit[..., None, :]
    slope, lower, upper = slope * unit, lower / unit, upper / unit
    free = np.linalg.solve(scaled + 1e-12 * np.eye(scaled.shape[-1]), slope[..., None])[..., 0]
    x = np.clip(free, lower, upper)
    left = slope - (scaled @ x[..., None])[..., 0]  # minus the gradient
    worse = ((slope + left) * x).sum(axis=-1, keepdims=True) < 0
    x, left = np.where(worse, 0.0, x), np.where(worse, slope, left)
    columns, x, left, lower, upper = (
        np.ascontiguousarray(np.moveaxis(a, -1, 0)) for a in (scaled, x, left, lower, upper)
    )
    for _ in range(SWEEPS):
        for k in range(len(x)):
            new = np.clip(x[k] + left[k], lower[k], upper[k])
            left -= np.moveaxis(columns[k], -1, 0) * (new - x[k])
            x[k] = new
    return np.moveaxis(x, 0, -1) * unit
