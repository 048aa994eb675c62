"""Derivatives of `lobe_fit.fit_lobes` by the values that a lobe is fitted to.

The fit minimises a function of four unknowns, whose gradient is zero at the result. Where values
change, the unknowns that are within their bounds follow so that it stays zero (the theorem of
implicit functions).
"""

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import DARK, KNEE, OVERSHOOT_WEIGHT

#: The numbers of a lobe that are fitted, by their places.
FITTED = (0, 1, 2)

#: Distance from its bounds at which an unknown counts as free; least reflectance of a lobe whose
#: width is one; step of central differences; and iterations for the diffuse term.
_INSIDE, _VISIBLE, _STEP, _ITERATIONS = 1e-6, 1e-4, 1e-5, 40


def fit_slopes(f: np.ndarray, lobe: np.ndarray) -> np.ndarray:
    """Return the derivatives float64 (N, 3, P) of alpha, normal and grazing by f (N, P).

    lobe (N, 6): the lobes fitted to f.
    """
    f = np.maximum(np.asarray(f, np.float64), 0.0)
    fitted = np.asarray(lobe, np.float64)[:, FITTED]
    x = np.column_stack([_diffuse(f, fitted), fitted[:, 1:], np.log(fitted[:, 0])])
    approximation, columns = _approximation(x, f.shape[-1])
    scale = 1 / (f + DARK)
    error = (approximation - f) * scale
    # Of the summands' first derivative by the error, half, and of the second.
    second = np.where(error > 0, OVERSHOOT_WEIGHT, np.where(error > -KNEE, 1.0, 0.0))
    first = np.where(error > -KNEE, second * error, -KNEE)
    curvature = (columns * (second * scale**2)[:, None]) @ np.swapaxes(columns, -1, -2)
    for k in range(4):
        step = _STEP * np.eye(4)[k]
        upper, lower = (_approximation(x + way * step, f.shape[-1])[1] for way in (1, -1))
        bent = (upper - lower) / (2 * _STEP)
        curvature[..., k] += (bent * (first * scale)[:, None]).sum(axis=-1)
    right = columns * (scale**2 * (second * (1 + error) + first))[:, None]
    free = _free(x)
    both = free[:, :, None] & free[:, None, :]
    curvature = np.where(both, curvature, np.eye(4))
    slopes = np.linalg.solve(curvature, np.where(free[..., None], right, 0.0))
    return np.stack([slopes[:, 3] * fitted[:, :1], slopes[:, 1], slopes[:, 2]], axis=1)


def _approximation(x: np.ndarray, probes: int) -> tuple[np.ndarray, np.ndarray]:
    """The approximation of f (N, P), and its derivatives (N, 4, P) by the unknowns x (N, 4).

    These are the diffuse term, the factors normal and grazing, and ln alpha.
    """
    wi, wo = (w.astype(np.float64) for w in probe_pairs(probes))
    alpha = np.exp(x[:, 3, None])
    stepped = lobes.shape(alpha * (1 + 1e-20j), wi, wo)
    shape, slope = stepped.real, stepped.imag / 1e-20
    fifth = (1 - lobes.cosine_to_facet(wi, wo)) ** 5
    factor = x[:, 1, None] * (1 - fifth) + x[:, 2, None] * fifth
    white = np.full_like(shape, 1 / np.pi)
    columns = [white, shape * (1 - fifth), shape * fifth, slope * factor]
    return x[:, :1] / np.pi + shape * factor, np.stack(columns, axis=1)


def _diffuse(f: np.ndarray, fitted: np.ndarray) -> np.ndarray:
    """The diffuse term (N,) that belongs to fitted numbers (N, 3), by reweighted least squares."""
    x = np.column_stack([np.zeros(len(f)), fitted[:, 1:], np.log(fitted[:, 0])])
    top, _ = _approximation(x, f.shape[-1])
    scale = 1 / (f + DARK)
    for _ in range(_ITERATIONS):
        error = (top + x[:, :1] / np.pi - f) * scale
        weights = np.where(error > 0, OVERSHOOT_WEIGHT, KNEE / np.maximum(-error, KNEE)) * scale**2
        x[:, 0] = np.maximum(np.pi * (weights * (f - top)).sum(-1) / weights.sum(-1), 0)
    return x[:, 0]


def _free(x: np.ndarray) -> np.ndarray:
    """Mask (N, 4) of the unknowns that are within their bounds."""
    factors = x[:, 1:3]
    within = (factors > _INSIDE) & (factors < 1 - _INSIDE)
    width = (x[:, 3] > np.log(MIN_ALPHA) + _INSIDE) & (x[:, 3] < -_INSIDE)
    return np.column_stack([x[:, 0] > _INSIDE, within, width & (factors.max(axis=-1) > _VISIBLE)])
