"""Models of few parameters, and small networks, fitted to the values of a BRDF.

The parameters of `principled` and of OpenPBR's recipe are found by least squares of ln(1 + f cos)
at the pairs of `benchmarks.rivals.ggx_fit`, weighted by energy, from several initial values.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from benchmarks.measures import Brdf, bsdf_values
from benchmarks.rivals import ggx_fit, nbrdf
from research.rivals import openpbr_recipe as recipe
from scipy.optimize import least_squares

from urushi.core import table
from urushi.core.directions import turned

#: Pairs of a fit, evaluations of its residuals at most, and step of their derivatives.
PAIRS, EVALUATIONS, STEP = 1200, 40, 1e-3
#: Passes of an NBRDF's training; thirty gave the same errors in a trial.
PASSES = 10
PRINCIPLED, RECIPE = "principled, fitted", "OpenPBR's recipe, fitted"
GGX, NBRDF = "two GGX lobes, fitted", "NBRDF, trained"


@cache
def pairs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The pairs (N, 3) of `principled` and of the recipe, of every azimuth, and weights (N,)."""
    rng = np.random.default_rng(0)
    chosen = rng.permutation(len(ggx_fit.pairs()[2]))[:PAIRS]
    *sides, weight = (column[chosen] for column in ggx_fit.pairs())
    turn = rng.uniform(0, 2 * np.pi, PAIRS)
    wi, wo = (turned(w, turn).astype(np.float32) for w in sides)
    return wi, wo, weight / weight.mean()


def tabulated(values: np.ndarray) -> Brdf:
    """f of values (N, C) at `table.node_pairs`, interpolated."""
    rows = table.table_of_values(values)
    return lambda wi, wo: table.interpolated(rows, wi, wo)


@dataclass(frozen=True)
class Form:
    """A model of few parameters."""

    ranges: dict[str, tuple[float, float]]  # by name, the least and the greatest value
    colours: tuple[str, ...]  # names of the parameters that have one value for each channel
    # Of some parameters; others begin in the middle of their range
    initial_guesses: tuple[dict[str, float], ...]
    # (parameters, wi, wo) -> (N, 3) [1/sr]
    f: Callable[[dict[str, Any], np.ndarray, np.ndarray], np.ndarray]

    def size(self) -> int:
        """Number of parameters of an isotropic material in RGB."""
        return len(self.ranges) + 2 * len(self.colours)


def fitted(name: str, f: Brdf, channels: int = 1) -> Brdf:
    """The model of a name, `GGX` and the like, fitted to an isotropic f."""
    if name in FORMS:
        return fit(FORMS[name], f(*pairs()[:2]), channels)
    found: Any = ggx_fit.fit(f, 2) if name == GGX else nbrdf.train(f, passes=PASSES)
    return lambda wi, wo: found.f(wi, wo)[:, :channels]


def fit(form: Form, values: np.ndarray, channels: int = 1) -> Brdf:
    """Fit a form to values (`PAIRS`, C) at `pairs`."""
    (wi, wo, weight), ranges = pairs(), form.ranges
    counts = [channels if name in form.colours else 1 for name in ranges]
    low, high = np.repeat(list(ranges.values()), counts, axis=0).T
    root, cosine = np.sqrt(weight)[:, None], wi[:, 2:]
    target = np.log1p(values * cosine)

    def evaluate(x: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        parts = np.split(low + x * (high - low), np.cumsum(counts)[:-1])
        parameters = {
            name: np.broadcast_to(part, 3) if name in form.colours else float(part[0])
            for name, part in zip(ranges, parts, strict=True)
        }
        return np.asarray(form.f(parameters, wi, wo), np.float64)[:, :channels]

    def residuals(x: np.ndarray) -> np.ndarray:
        f = evaluate(x, wi, wo)
        return ((np.log1p(np.maximum(f, 0) * cosine) - target) * root).ravel()

    def jacobian(x: np.ndarray) -> np.ndarray:
        steps = np.diag(np.where(x < 0.5, STEP, -STEP))
        moved = np.stack([residuals(x + step) for step in steps], axis=1)
        return (moved - residuals(x)[:, None]) / np.diag(x + steps - x)

    def begin(guess: dict[str, float]) -> np.ndarray:
        """The initial place in the ranges, away from their ends."""
        initial = {name: sum(limits) / 2 for name, limits in ranges.items()} | guess
        return np.clip((np.repeat(list(initial.values()), counts) - low) / (high - low), 0.02, 0.98)

    search = {"max_nfev": EVALUATIONS, "x_scale": 0.1, "ftol": 1e-4}
    solutions = [
        least_squares(residuals, begin(guess), jacobian, (0, 1), **search)
        for guess in form.initial_guesses
    ]
    return partial(evaluate, min(solutions, key=lambda solution: solution.cost).x)


@cache
def _principled() -> tuple[Any, Any]:
    """Mitsuba's `principled` and its parameters."""
    names = ("roughness", "metallic", "clearcoat", "clearcoat_gloss")
    colour = {"type": "rgb", "value": [0.5] * 3}
    constant = dict.fromkeys(names, 0.5)
    bsdf = mi.load_dict({"type": "principled", "specular": 0.5, "base_color": colour, **constant})
    return bsdf, mi.traverse(bsdf)


def _principled_f(parameters: dict[str, Any], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    bsdf, entries = _principled()
    for name, value in parameters.items():
        number = mi.Color3f(*map(float, value)) if name == "base_color" else mi.Float(value)
        dr.make_opaque(number)  # a constant would make a new kernel
        entries[name if name == "specular" else f"{name}.value"] = number
    entries.update()
    return bsdf_values(bsdf, wi, wo)


_UNIT = (0.0, 1.0)

FORMS = {
    PRINCIPLED: Form(
        {
            "base_color": _UNIT,
            "roughness": (0.1, 1.0),
            "metallic": _UNIT,
            "specular": (0.01, 1.0),
            "clearcoat": _UNIT,
            "clearcoat_gloss": _UNIT,
        },
        ("base_color",),
        ({"roughness": 0.3, "metallic": 0.7}, {"roughness": 0.7}),
        _principled_f,
    ),
    RECIPE: Form(
        {
            "base_color": _UNIT,
            "base_metalness": _UNIT,
            "specular_roughness": (0.1, 1.0),
            "specular_ior": (1.0, 3.0),
            "coat_weight": _UNIT,
            "coat_roughness": (0.1, 1.0),
            "coat_ior": (1.02, 2.0),
            "coat_color": (0.01, 1.0),
        },
        ("base_color", "coat_color"),
        (
            {"base_metalness": 0.7, "specular_roughness": 0.7, "coat_roughness": 0.3,
             "coat_weight": 0.9},
            {"base_metalness": 0.7, "specular_roughness": 0.3, "coat_roughness": 0.7,
             "coat_weight": 0.9},
        ),
        lambda given, wi, wo: recipe.f(given, wi.astype(float), wo.astype(float)),
    ),
}  # fmt: skip

FITTED: Sequence[str] = (PRINCIPLED, RECIPE, GGX, NBRDF)
