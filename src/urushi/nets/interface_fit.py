"""Recognition of bare interfaces by their values: GGX with the exact Fresnel term.

Schlick's term, by which `lobe_fit` approximates, differs by some per cent from the exact one of a
metal or a dielectric. Where it leaves only this much, a width and a complex index are fitted, by
damped steps from several indices that have the same reflectance at normal incidence. They are used
if they give all values.
"""

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets import lobe as lobes
from urushi.nets.least_squares import damped_step
from urushi.nets.lobe_fit import DARK, fit_lobes

#: Mean relative error of Schlick's term between which an exact one is looked for.
LEAST_ERROR, GREATEST_ERROR = 2e-3, 0.15

#: Greatest relative error of any value that the exact term may leave.
TOLERANCE = 0.005

#: Number of steps, the first damping relative to the mean curvature, and its factors after steps
#: that lower the error and that do not.
STEPS, DAMPING, DECREASE, INCREASE = 20, 1e-3, 0.2, 10.0

#: Bounds of ln alpha, eta and k.
LOWER, UPPER = np.array([np.log(MIN_ALPHA), 0.02, 0.0]), np.array([0.0, 8.0, 12.0])

#: Indices eta of the metals that are tried.
METALS = (0.2, 1.0, 2.5)


def find_lobes(f: np.ndarray) -> np.ndarray:
    """Return the lobes float32 (..., 6) of BRDFs with values f (..., P) [1/sr] at `probe_pairs(P)`.

    Exact ones of bare interfaces, and those of `lobe_fit` of all other BRDFs.
    """
    rows = np.maximum(np.ascontiguousarray(f, np.float64).reshape(-1, f.shape[-1]), 0.0)
    found = exact_interfaces(rows, fit_lobes(rows))
    return found.reshape(*f.shape[:-1], found.shape[-1])


def exact_interfaces(f: np.ndarray, schlick: np.ndarray) -> np.ndarray:
    """Return lobes (N, 6): exact ones where they give f (N, P) [1/sr], or else those of `schlick`.

    schlick: (N, 6) the best lobes with Schlick's term.
    """
    wi, wo = (w.astype(np.float64) for w in probe_pairs(f.shape[-1]))
    error = np.abs(lobes.f(schlick[:, None].astype(np.float64), wi, wo) - f) / (f + DARK)
    mean = error.mean(axis=-1)
    rows = np.flatnonzero((mean > LEAST_ERROR) & (mean < GREATEST_ERROR) & (schlick[:, 1] > 0))
    result = schlick.copy()
    if len(rows):
        found, error = _fit(f[rows], schlick[rows].astype(np.float64))
        exact = rows[error < TOLERANCE]
        result[exact] = 0.0
        result[exact, 3] = 1.0
        result[exact, 0] = np.exp(found[error < TOLERANCE, 0])
        result[exact, 4:] = found[error < TOLERANCE, 1:]
    return result


def _fit(f: np.ndarray, schlick: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The best ln alpha, eta and k (N, 3), and their greatest relative errors (N,)."""
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
    first = [np.column_stack([np.log(schlick[:, 0]), eta, k]) for eta, k in starts]
    x, error = _descend(np.tile(f, (len(starts), 1)), np.concatenate(first))
    x, error = x.reshape(len(starts), -1, 3), error.reshape(len(starts), -1)
    best = error.argmin(axis=0), np.arange(len(f))
    return x[best], error[best]


def _descend(f: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unknowns (N, 3) after damped steps from x (N, 3), and their greatest errors (N,)."""
    x = np.clip(x, LOWER, UPPER)
    error, slopes = _errors(f, x)
    damping = np.full(len(f), DAMPING)
    for _ in range(STEPS):
        step = damped_step(
            slopes @ np.swapaxes(slopes, -1, -2), (slopes @ error[..., None])[..., 0], damping
        )
        new = np.clip(x - step, LOWER, UPPER)
        new_error, new_slopes = _errors(f, new)
        better = np.square(new_error).sum(axis=-1) < np.square(error).sum(axis=-1)
        x, error = np.where(better[:, None], new, x), np.where(better[:, None], new_error, error)
        slopes = np.where(better[:, None, None], new_slopes, slopes)
        damping *= np.where(better, DECREASE, INCREASE)
    return x, np.abs(error).max(axis=-1)


def _errors(f: np.ndarray, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Relative errors (N, P) of unknowns x (N, 3), and their derivatives (N, 3, P)."""
    wi, wo = (w.astype(np.float64) for w in probe_pairs(f.shape[-1]))
    cosine, scale = lobes.cosine_to_facet(wi, wo), 1 / (f + DARK)
    alpha, eta, k = np.exp(x[:, :1]), x[:, 1:2], x[:, 2:]
    shape, step = lobes.shape(alpha, wi, wo), 1e-5
    slope = (lobes.shape(alpha * (1 + step), wi, wo) - shape) / step
    reflected = lobes.fresnel(cosine, eta, k)
    by_eta = (lobes.fresnel(cosine, eta + step, k) - reflected) / step
    by_k = (lobes.fresnel(cosine, eta, k + step) - reflected) / step
    slopes = np.stack([slope * reflected, shape * by_eta, shape * by_k], axis=1)
    return (shape * reflected - f) * scale, slopes * scale[:, None]
