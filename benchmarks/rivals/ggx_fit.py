"""Least-squares fits of a Lambertian part and GGX lobes with Schlick's Fresnel term to any BRDF.

In a plain fit, the peak of the highlight outweighs everything else. Therefore cosine-weighted
values are compared after a compressive map, and pairs may be weighted by their solid angle. The
best choice depends on the material (Fores et al. 2012; Bieron and Peers 2020): a comparison should
take the best for each. Every fit starts from several initial widths.
"""

from collections.abc import Callable
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from benchmarks.rivals.nbrdf import Brdf
from scipy.optimize import least_squares, nnls
from threadpoolctl import threadpool_limits

from urushi.core import direction_sets
from urushi.core.directions import directions_at
from urushi.core.error_metrics import energy_weight
from urushi.measured.tabulated import bin_centres, evaluate
from urushi.nets import lobe as analytic


class GgxFit(NamedTuple):
    """A BRDF of a Lambertian part and lobes ks D G F / (4 cos cos).

    Channels share widths and Fresnel terms, and colours are free, as in Ngan et al. 2005
    ("Experimental analysis of BRDF models").
    """

    diffuse: np.ndarray  # (3,) the reflectance kd
    alpha: np.ndarray  # (L,) GGX widths
    f0: np.ndarray  # (L,) Schlick's (1994) reflectances at normal incidence
    weight: np.ndarray  # (L, 3) the colours ks

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """float32 (N, 3) [1/sr], without cosine, of unit vectors (N, 3)."""
        return evaluate(self.at, 3, wi, wo)

    def at(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """f (N, 3) of unit vectors above the horizon."""
        result = np.broadcast_to(self.diffuse / np.pi, (len(wi), 3))
        for alpha, f0, weight in zip(self.alpha, self.f0, self.weight, strict=True):
            result = result + grey(alpha, f0, wi, wo)[:, None] * weight
        return result


def grey(alpha: float, f0: float, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """D G F / (4 cos cos) (N,) with separable masking and Schlick's (1994) Fresnel term."""
    wi, wo = (w.astype(np.float64) for w in (wi, wo))
    edge = (1 - analytic.cosine_to_facet(wi, wo)) ** 5
    return analytic.shape(alpha, wi, wo) * (f0 + (1 - f0) * edge)


#: The compared quantity, a map of x = f cos theta_i. "linear": Ngan et al. 2005. "log": Löw et al.
#: 2012, ln(1 + x). "root": the cube root of Fores et al. 2012, with an offset that keeps its slope
#: finite.
LOSSES: dict[str, Callable[[np.ndarray], np.ndarray]] = {
    "linear": lambda x: x,
    "log": np.log1p,
    "root": lambda x: np.cbrt(x + 1e-3),
}

#: Exponents of the pair's weight, which is its solid angle times both cosines. 1 weights squared
#: errors by energy; 0.5 is half-way to equal weights, under which most of the weight lies near the
#: highlight, as in MERL's bins.
MEASURES = 0.5, 1.0

#: Initial widths of fits of one lobe and of two.
INITIAL_WIDTHS: dict[int, tuple[tuple[float, ...], ...]] = {
    1: ((0.01,), (0.05,), (0.15,), (0.4,)),
    2: ((0.01, 0.05), (0.02, 0.2), (0.05, 0.15), (0.1, 0.4), (0.3, 0.8)),
}

#: Narrowest and widest lobes.
ALPHAS = 0.002, 1.0

#: Bounds of the logarithms of kd and ks.
WEIGHTS = -14.0, 7.0

#: Bounds of the logit of f0.
F0 = -7.0, 7.0

#: Smallest cosine of a fitted direction: grazing angles are rarely measured.
LEAST_COSINE = 0.02

#: Bins of the fitted pairs, as MERL's: along theta_h, theta_d and phi_d.
ANGLES = 64, 16, 8


def best(f: Brdf, lobes: int) -> GgxFit:
    """The fit of up to `lobes` lobes, by any loss and measure, of the least E; as of `fit`.

    E is that of pairs of cosine density, which no fit has seen.
    """
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(2), 2048)
    truth, cosines = np.asarray(f(wi, wo), np.float64), (wi[:, 2], wo[:, 2])
    values = f(*pairs()[:2])
    ways = product(range(1, lobes + 1), LOSSES, MEASURES)
    fits = [fit(lambda *_: values, *how) for how in ways]
    errors = [
        np.abs(found.f(wi, wo) - truth).sum(axis=1) @ energy_weight(*cosines) for found in fits
    ]
    return fits[int(np.argmin(errors))]


def fit(f: Brdf, lobes: int = 1, loss: str = "log", measure: float = 1.0) -> GgxFit:
    """Fit a Lambertian part and GGX lobes to a BRDF.

    Parameters of the search are ln kd (3), then for every lobe ln alpha, logit f0, ln ks (3).

    Args:
        f: the BRDF.
        lobes: one or two.
        loss: a name in `LOSSES`.
        measure: see `MEASURES`.
    """
    (wi, wo, angles), compared = pairs(), LOSSES[loss]
    values = np.broadcast_to(np.asarray(f(wi, wo), np.float64), (len(wi), 3))
    weight, cosine = angles[:, None] ** (measure / 2), wi[:, 2:].astype(np.float64)
    weight = weight / weight.mean()
    target = compared(values * cosine)
    bounds = np.array([WEIGHTS] * 3 + [np.log(ALPHAS), F0, *[WEIGHTS] * 3] * lobes).T

    def residuals(x: np.ndarray) -> np.ndarray:
        return ((compared(_model(x).at(wi, wo) * cosine) - target) * weight).ravel()

    with threadpool_limits(1):  # more threads slow such small matrices down
        solutions = [
            least_squares(
                residuals, _initial(alphas, values), "2-point", bounds, max_nfev=60, x_scale="jac"
            )
            for alphas in INITIAL_WIDTHS[lobes]
        ]
    return _model(min(solutions, key=lambda solution: solution.cost).x)


def _model(x: np.ndarray) -> GgxFit:
    alpha, f0, *weight = x[3:].reshape(-1, 5).T
    return GgxFit(np.exp(x[:3]), np.exp(alpha), 1 / (1 + np.exp(-f0)), np.exp(weight).T)


def _initial(alphas: tuple[float, ...], values: np.ndarray) -> np.ndarray:
    """Parameters of the given widths, f0 = 0.2, and the weights of least relative error."""
    lobes, f0 = [grey(alpha, 0.2, *pairs()[:2]) for alpha in alphas], np.log(0.2 / 0.8)
    columns = np.stack([np.full(len(values), 1 / np.pi), *lobes], axis=1)
    weights = []
    for value in values.T:
        scale = 1 / (value + 0.05 * value.mean() + 1e-6)
        weights.append(nnls(columns * scale[:, None], value * scale)[0])
    diffuse, *logs = np.log(np.clip(weights, 1e-3, 1e2)).T
    parts = [np.r_[np.log(alpha), f0, log] for alpha, log in zip(alphas, logs, strict=True)]
    return np.concatenate([diffuse, *parts])


@cache
def pairs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pairs (N, 3) that are fitted, a grid of Rusinkiewicz's angles above the horizon.

    Returns:
        wi, wo and weights (N,): solid angles times cosines, up to a factor.
    """
    theta_h, theta_d, phi_d = (x.ravel() for x in np.broadcast_arrays(*bin_centres(ANGLES)))
    wi, wo = directions_at(theta_h, theta_d, phi_d)
    # dwi dwo = 4 cos theta_d dh dd (Rusinkiewicz 1998); theta_h is the square of an even spacing.
    weight = np.sin(theta_h) * np.sqrt(theta_h) * np.sin(theta_d) * np.cos(theta_d)
    above = np.minimum(wi[:, 2], wo[:, 2]) > LEAST_COSINE
    weight = (weight * wi[:, 2] * wo[:, 2])[above]
    return wi[above].astype(np.float32), wo[above].astype(np.float32), weight
