"""Recognition of bare interfaces by their values: GGX with the exact Fresnel term.

Schlick's term, by which `lobe_fit` approximates, differs by some per cent from the exact one of a
metal or a dielectric. Where its error is as small, a width and a complex index are fitted, by
damped steps from several indices that have the same reflectance at normal incidence. They are used
if they give all values.
"""

import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.core.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.lobe_fit import DARK, fit_lobes

#: Range of the mean relative error of Schlick's term in which an exact term is tried.
LEAST_ERROR, GREATEST_ERROR = 2e-3, 0.15

#: Greatest relative error of any value that the exact term may leave.
TOLERANCE = 0.005

#: Number of steps; damping of the first, relative to the mean of the curvature's diagonal, and its
#: factors after a step that lowers the errors and after any other, which is not taken.
STEPS, DAMPING, DECREASE, INCREASE = 20, 1e-3, 0.2, 10.0

#: Bounds of eta and k, the last two unknowns.
LOWER, UPPER = [0.02, 0.0], [8.0, 12.0]

#: Indices eta of the metals that are tried.
METALS = (0.2, 1.0, 2.5)


def find_lobes(f: np.ndarray, widths: int = 1) -> np.ndarray:
    """Return the lobes float32 (..., N) of BRDFs with values f (..., P) [1/sr] at the probe pairs.

    A bare interface gets its exact lobe, any other BRDF the lobe of `lobe_fit.fit_lobes`, which
    documents the pairs and N.
    """
    values = np.maximum(np.ascontiguousarray(f, np.float64).reshape(-1, f.shape[-1]), 0.0)
    result = fit_lobes(values, widths)
    schlick = result.astype(np.float64)
    wi, wo = (w.astype(np.float64) for w in probe_pairs(f.shape[-1], widths))
    error = np.abs(lobes.f(schlick[:, None], wi, wo) - values) / (values + DARK)
    mean = error.mean(axis=-1)
    rows = np.flatnonzero((mean > LEAST_ERROR) & (mean < GREATEST_ERROR) & (schlick[:, 1] > 0))
    if len(rows):
        found, error = _fit(values[rows], schlick[rows], widths)
        exact, found = rows[error < TOLERANCE], found[error < TOLERANCE]
        result[exact] = 0.0
        result[exact, 3] = 1.0
        for column, place in enumerate(lobes.WIDTH_PLACES[widths]):
            result[exact, place] = np.exp(found[:, column])
        result[exact, 4:6] = found[:, widths:]
    return result.reshape(*f.shape[:-1], result.shape[-1])


def _fit(f: np.ndarray, schlick: np.ndarray, widths: int) -> tuple[np.ndarray, np.ndarray]:
    """The best logarithms of widths, eta and k (N, U), and their greatest relative errors (N,)."""
    root = np.sqrt(np.clip(schlick[:, 1], 1e-4, 0.98))
    bright = root**2
    glass = (1 + root) / (1 - root)
    starts = [(glass, 0 * glass), (1 / glass, 0 * glass)] + [
        (
            np.full_like(bright, eta),
            np.sqrt(np.maximum((bright * (1 + eta) ** 2 - (1 - eta) ** 2) / (1 - bright), 0.1)),
        )
        for eta in METALS
    ]
    logs = np.log(schlick[:, lobes.WIDTH_PLACES[widths]])
    first = [np.column_stack([logs, eta, k]) for eta, k in starts]
    lower, upper = [np.log(MIN_ALPHA)] * widths + LOWER, [0.0] * widths + UPPER
    every = np.tile(f, (len(starts), 1))

    x = np.clip(np.concatenate(first), lower, upper)
    error, slopes = _errors(every, x)
    damping = np.full((len(x), 1, 1), DAMPING)
    for _ in range(STEPS):  # Marquardt 1963
        curvature = slopes @ np.swapaxes(slopes, -1, -2)
        mean = np.trace(curvature, axis1=1, axis2=2)[:, None, None] / x.shape[1]
        damped = curvature + (damping * mean + 1e-12) * np.eye(x.shape[1])
        step = np.linalg.solve(damped, slopes @ error[..., None])[..., 0]
        moved = np.clip(x - step, lower, upper)
        new, new_slopes = _errors(every, moved)
        better = np.square(new).sum(axis=-1) < np.square(error).sum(axis=-1)  # false for NaN
        x[better], error[better], slopes[better] = moved[better], new[better], new_slopes[better]
        damping *= np.where(better[:, None, None], DECREASE, INCREASE)
    error = np.abs(error).max(axis=-1).reshape(len(starts), -1)
    best = error.argmin(axis=0), np.arange(len(f))
    return x.reshape(len(starts), *first[0].shape)[best], error[best]


def _errors(f: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors (N, P) of unknowns x (N, U), and their derivatives (N, U, P)."""
    wi, wo = (w.astype(np.float64) for w in probe_pairs(f.shape[-1], x.shape[-1] - len(LOWER)))
    cosine, scale = lobes.cosine_to_facet(wi, wo), 1 / (f + DARK)

    def errors(x: np.ndarray) -> np.ndarray:
        *logs, eta, k = x.T[..., None]
        widths = [np.exp(log) for log in logs]
        shape = lobes.shape(Widths(*widths) if len(widths) == 2 else widths[0], wi, wo)
        return (shape * lobes.fresnel(cosine, eta, k) - f) * scale

    here = errors(x)
    slopes = [(errors(x + 1e-5 * unit) - here) / 1e-5 for unit in np.eye(x.shape[-1])]
    return here, np.stack(slopes, axis=1)
