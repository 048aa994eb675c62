"""Least-squares fits of a Lambertian part and GGX lobes with Schlick's Fresnel term to any BRDF.

In a plain fit, the peak of the highlight outweighs everything else. Therefore cosine-weighted
values are compared after a compressive map, and pairs may be weighted by their solid angle. The
best choice depends on the material (Fores et al. 2012; Bieron and Peers 2020): a comparison should
take the best for each. Every fit starts from several initial widths.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
from scipy.optimize import least_squares, nnls
from threadpoolctl import threadpool_limits

from urushi.core import direction_sets
from urushi.core.directions import directions_at
from urushi.core.error_metrics import energy_weight
from urushi.errors import ParameterError
from urushi.measured.tabulated import evaluate
from urushi.nets import lobe as analytic


@dataclass(frozen=True)
class Lobe:
    """One lobe, ks D G F / (4 cos cos).

    Attributes:
        alpha: GGX width, the same in all channels.
        f0: Schlick's (1994) reflectance at normal incidence, the same in all channels.
        weight: (3,) the colour ks that multiplies it.
    """

    alpha: float
    f0: float
    weight: np.ndarray


@dataclass(frozen=True)
class GgxFit:
    """A BRDF of a Lambertian part and lobes.

    Channels share widths and Fresnel terms, and colours are free, as in Ngan et al. 2005
    ("Experimental analysis of BRDF models").

    Attributes:
        diffuse: (3,) the reflectance kd.
        lobes: one or two.
    """

    diffuse: np.ndarray
    lobes: tuple[Lobe, ...]

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Evaluate: float32 (N, 3) [1/sr], without cosine, zero below the horizon.

        wi, wo: (N, 3) unit vectors.

        Raises:
            ParameterError: wrong shapes, or directions that are not unit vectors.
        """
        return evaluate(self._f, 3, wi, wo)

    def _f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        geometry = Geometry.of(wi, wo)
        result = np.broadcast_to(self.diffuse / np.pi, (len(wi), 3))
        for lobe in self.lobes:
            grey = shape(geometry, lobe.alpha) * schlick(geometry, lobe.f0)
            result = result + grey[:, None] * lobe.weight
        return result


class Geometry(NamedTuple):
    """Pairs of directions.

    Attributes:
        wi, wo: float64 (N, 3), unit vectors above the horizon.
        edge: (N,) (1 - cos theta_d)^5, of Schlick's Fresnel term.
    """

    wi: np.ndarray
    wo: np.ndarray
    edge: np.ndarray

    @classmethod
    def of(cls, wi: np.ndarray, wo: np.ndarray) -> "Geometry":
        """wi, wo: (N, 3), unit vectors above the horizon."""
        wi, wo = (w.astype(np.float64) for w in (wi, wo))
        return cls(wi, wo, (1 - analytic.cosine_to_facet(wi, wo)) ** 5)


def shape(g: Geometry, alpha: float) -> np.ndarray:
    """D G / (4 cos cos) with separable masking."""
    return analytic.shape(alpha, g.wi, g.wo)


def schlick(g: Geometry, f0: float) -> np.ndarray:
    """Schlick's (1994) Fresnel term."""
    return f0 + (1 - f0) * g.edge


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

#: Numbers of angles of the fitted pairs: theta_h (spaced as squares, like MERL's bins), theta_d,
#: phi_d.
ANGLES = 64, 16, 8


#: f(wi, wo) -> (N, 3) or (N, 1) [1/sr] for float32 unit vectors (N, 3).
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


def best(f: Brdf, lobes: int) -> GgxFit:
    """The fit of up to `lobes` lobes, by any loss and measure, of the least E; as of `fit`.

    E is that of pairs of cosine density, which no fit has seen.
    """
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(2), 2048)
    truth, cosines = np.asarray(f(wi, wo), np.float64), (wi[:, 2], wo[:, 2])
    fits = [fit(f, n, *how) for n in range(1, lobes + 1) for how in product(LOSSES, MEASURES)]
    errors = [
        np.abs(found.f(wi, wo) - truth).sum(axis=1) @ energy_weight(*cosines) for found in fits
    ]
    return fits[int(np.argmin(errors))]


def fit(f: Brdf, lobes: int = 1, loss: str = "log", measure: float = 1.0) -> GgxFit:
    """Fit a Lambertian part and GGX lobes to a BRDF.

    Args:
        f: f(wi, wo) -> (N, 3) or (N, 1) [1/sr] for float32 unit vectors (N, 3).
        lobes: one or two.
        loss: a name in `LOSSES`.
        measure: see `MEASURES`.

    Raises:
        ParameterError: another number of lobes or another loss.
    """
    if lobes not in INITIAL_WIDTHS or loss not in LOSSES:
        raise ParameterError(
            f"cannot fit {lobes} lobes by the loss '{loss}'; "
            f"fit {' or '.join(map(str, INITIAL_WIDTHS))} by one of {', '.join(LOSSES)}"
        )
    wi, wo = pairs()
    values = np.broadcast_to(np.asarray(f(wi, wo), np.float64), (len(wi), 3))
    weight = solid_angles() ** (measure / 2)
    problem = _Problem(Geometry.of(wi, wo), values, loss, weight / weight.mean())
    with threadpool_limits(1):  # more threads slow such small matrices down
        solutions = [
            least_squares(
                problem.residuals,
                problem.initial(alphas),
                "2-point",
                problem.bounds(lobes),
                max_nfev=60,
                x_scale="jac",
            )
            for alphas in INITIAL_WIDTHS[lobes]
        ]
    return problem.model(min(solutions, key=lambda solution: solution.cost).x)


def pairs() -> tuple[np.ndarray, np.ndarray]:
    """The pairs (N, 3) that are fitted: a grid of Rusinkiewicz's angles, above the horizon."""
    wi, wo, _ = _grid()
    return wi, wo


def solid_angles() -> np.ndarray:
    """Weights of the fitted pairs (N,): solid angles times cosines, up to a factor."""
    return _grid()[2]


@cache
def _grid() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    half, difference, turn = ((np.arange(n) + 0.5) / n for n in ANGLES)
    grid = np.meshgrid(half**2 * (np.pi / 2), difference * (np.pi / 2), turn * np.pi, indexing="ij")
    theta_h, theta_d, phi_d = (angle.ravel() for angle in grid)
    wi, wo = directions_at(theta_h, theta_d, phi_d)
    # dwi dwo = 4 cos theta_d dh dd (Rusinkiewicz 1998); theta_h is the square of an even spacing.
    weight = np.sin(theta_h) * np.sqrt(theta_h) * np.sin(theta_d) * np.cos(theta_d)
    above = np.minimum(wi[:, 2], wo[:, 2]) > LEAST_COSINE
    weight = (weight * wi[:, 2] * wo[:, 2])[above]
    return wi[above].astype(np.float32), wo[above].astype(np.float32), weight


class _Problem:
    """Residuals of a vector of parameters.

    They are ln kd (3), then for every lobe ln alpha, logit f0, ln ks (3).
    """

    def __init__(
        self, geometry: Geometry, values: np.ndarray, loss: str, weight: np.ndarray
    ) -> None:
        self._geometry = geometry
        self._weight = weight[:, None]
        self._map = LOSSES[loss]
        self._cosine = geometry.wi[:, 2:]
        self._target = self._map(values * self._cosine)
        self._values = values

    def bounds(self, lobes: int) -> tuple[np.ndarray, np.ndarray]:
        lobe = [np.log(ALPHAS), F0, *[WEIGHTS] * 3]
        lower, upper = np.array([WEIGHTS] * 3 + lobe * lobes).T
        return lower, upper

    def initial(self, alphas: tuple[float, ...]) -> np.ndarray:
        """Parameters of the given widths, f0 = 0.2, and the weights of least relative error."""
        f0 = 0.2
        grey = [shape(self._geometry, alpha) * schlick(self._geometry, f0) for alpha in alphas]
        columns = np.stack([np.full(len(self._values), 1 / np.pi), *grey], axis=1)
        weights = []
        for value in self._values.T:
            scale = 1 / (value + 0.05 * value.mean() + 1e-6)
            weights.append(nnls(columns * scale[:, None], value * scale)[0])
        logs = np.log(np.clip(weights, 1e-3, 1e2)).T  # (1 + lobes, 3)
        logit = np.log(f0 / (1 - f0))
        parts = [
            np.r_[np.log(alpha), logit, log] for alpha, log in zip(alphas, logs[1:], strict=True)
        ]
        return np.concatenate([logs[0], *parts])

    def model(self, x: np.ndarray) -> GgxFit:
        return GgxFit(
            np.exp(x[:3]),
            tuple(
                Lobe(float(np.exp(p[0])), float(1 / (1 + np.exp(-p[1]))), np.exp(p[2:]))
                for p in x[3:].reshape(-1, 5)
            ),
        )

    def residuals(self, x: np.ndarray) -> np.ndarray:
        model = self.model(x)
        value = np.broadcast_to(model.diffuse / np.pi, self._values.shape)
        for lobe in model.lobes:
            grey = shape(self._geometry, lobe.alpha) * schlick(self._geometry, lobe.f0)
            value = value + grey[:, None] * lobe.weight
        return ((self._map(value * self._cosine) - self._target) * self._weight).ravel()
