"""Derivatives of `lobe_fit.fit_lobes` by the values that a lobe is fitted to.

The fit minimises a function of four or five unknowns, whose gradient is zero at the result. Where
values change, the unknowns that are within their bounds follow so that it stays zero (the theorem
of implicit functions).
"""

import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import DARK, KNEE, OVERSHOOT_WEIGHT

#: The numbers of a lobe with one width or two that are fitted, by their places.
FITTED = {1: (0, 1, 2), 2: (0, 1, 2, 6)}

#: Distance from its bounds at which an unknown counts as free; least reflectance of a lobe whose
#: width is one; step of central differences; and iterations for the diffuse term.
_INSIDE, _VISIBLE, _STEP, _ITERATIONS = 1e-6, 1e-4, 1e-5, 40


def fit_slopes(f: np.ndarray, lobe: np.ndarray, widths: int = 1) -> np.ndarray:
    """Return the derivatives float64 (N, K, P) of the K `FITTED` numbers by f (N, P).

    lobe (N, L): the lobes of this number of widths fitted to f.
    """
    f = np.maximum(np.asarray(f, np.float64), 0.0)
    lobe = np.asarray(lobe, np.float64)
    alphas = lobe[:, lobes.WIDTH_PLACES[widths]]
    x = np.column_stack([np.zeros(len(f)), lobe[:, 1:3], np.log(alphas)])
    x[:, 0] = _diffuse(f, x)
    approximation, columns = _approximation(x, f.shape[-1])
    scale = 1 / (f + DARK)
    error = (approximation - f) * scale
    # Half the second and half the first derivative of each summand by its error.
    second = np.where(error > 0, OVERSHOOT_WEIGHT, np.where(error > -KNEE, 1.0, 0.0))
    first = np.where(error > -KNEE, second * error, -KNEE)
    curvature = (columns * (second * scale**2)[:, None]) @ np.swapaxes(columns, -1, -2)
    unknowns = np.eye(x.shape[-1])
    for k, unknown in enumerate(unknowns):
        step = _STEP * unknown
        upper, lower = (_approximation(x + way * step, f.shape[-1])[1] for way in (1, -1))
        bent = (upper - lower) / (2 * _STEP)
        curvature[..., k] += (bent * (first * scale)[:, None]).sum(axis=-1)
    right = columns * (scale**2 * (second * (1 + error) + first))[:, None]
    # Unknowns within their bounds.
    factors, logs = x[:, 1:3], x[:, 3:]
    within = (factors > _INSIDE) & (factors < 1 - _INSIDE)
    width = (logs > np.log(MIN_ALPHA) + _INSIDE) & (logs < -_INSIDE)
    seen = factors.max(axis=-1, keepdims=True) > _VISIBLE
    free = np.column_stack([x[:, 0] > _INSIDE, within, width & seen])
    both = free[:, :, None] & free[:, None, :]
    curvature = np.where(both, curvature, unknowns)
    slopes = np.linalg.solve(curvature, np.where(free[..., None], right, 0.0))
    of_widths = slopes[:, 3:] * alphas[..., None]
    return np.concatenate([of_widths[:, :1], slopes[:, 1:3], of_widths[:, 1:]], axis=1)


def _approximation(x: np.ndarray, probes: int) -> tuple[np.ndarray, np.ndarray]:
    """The approximation of f (N, P), and its derivatives (N, U, P) by the unknowns x (N, U).

    These are the diffuse term, the factors normal and grazing, and the logarithm of each width.
    """
    wi, wo = (w.astype(np.float64) for w in probe_pairs(probes, x.shape[-1] - 3))
    alphas, step = [np.exp(column[:, None]) for column in x[:, 3:].T], 1 + 1e-20j
    stepped = [[*alphas[:k], alpha * step, *alphas[k + 1 :]] for k, alpha in enumerate(alphas)]
    shapes = [lobes.shape(Widths(*a) if len(a) == 2 else a[0], wi, wo) for a in stepped]
    shape, slopes = shapes[0].real, [each.imag / 1e-20 for each in shapes]
    fifth = (1 - lobes.cosine_to_facet(wi, wo)) ** 5
    factor = x[:, 1, None] * (1 - fifth) + x[:, 2, None] * fifth
    white = np.full_like(shape, 1 / np.pi)
    columns = [white, shape * (1 - fifth), shape * fifth, *(slope * factor for slope in slopes)]
    return x[:, :1] / np.pi + shape * factor, np.stack(columns, axis=1)


def _diffuse(f: np.ndarray, x: np.ndarray) -> np.ndarray:
    """The diffuse term (N,) that belongs to the other unknowns of x (N, U).

    By reweighted least squares; x has a diffuse term of 0.
    """
    top, _ = _approximation(x, f.shape[-1])
    scale, diffuse = 1 / (f + DARK), np.zeros(len(f))
    for _ in range(_ITERATIONS):
        error = (top + diffuse[:, None] / np.pi - f) * scale
        weights = np.where(error > 0, OVERSHOOT_WEIGHT, KNEE / np.maximum(-error, KNEE)) * scale**2
        diffuse = np.maximum(np.pi * (weights * (f - top)).sum(-1) / weights.sum(-1), 0)
    return diffuse
