"""Rough conductors: a GGX surface with Schlick's Fresnel term, or with a complex index."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import Widths
from urushi.core import fresnel
from urushi.errors import ParameterError
from urushi.walk.bottoms.bottom import (
    Description,
    Microfacet,
    Rough,
    Value,
    draw_alpha,
    maker,
    store,
    store_alpha,
)


@dataclass(frozen=True)
class Conductor(Rough, Description):
    """A rough conductor: GGX of width `alpha`, and Schlick's `r0` or a complex index `eta`, `k`.

    The index is relative to the medium above.
    """

    alpha: Value | Widths
    r0: Value | None = None
    eta: Value | None = None
    k: Value | None = None

    def __post_init__(self) -> None:
        store_alpha(self, self.alpha, "the conductor's")
        if self.r0 is not None and self.eta is None and self.k is None:
            store(self, "r0", checks.reflectance(self.r0, "the conductor's r0"))
        elif self.r0 is None and self.eta is not None and self.k is not None:
            store(self, "eta", checks.nonnegative(self.eta, "the conductor's eta"))
            store(self, "k", checks.nonnegative(self.k, "the conductor's k"))
        else:
            raise ParameterError(
                "a conductor needs either r0 (Schlick) or both eta and k (complex index of "
                "refraction)"
            )

    def under(self, index: npt.ArrayLike) -> "Conductor":
        if self.eta is None or self.k is None:
            return self
        eta, k = (np.divide(value, index) for value in (self.eta, self.k))
        return replace(self, eta=eta, k=k)  # type: ignore[arg-type]

    @property
    def kind(self) -> str:
        return "conductor" if self.r0 is not None else "conductor_complex"


@maker
def conductor(
    alpha: npt.ArrayLike | None = None,
    r0: npt.ArrayLike | None = None,
    *,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
    eta: npt.ArrayLike | None = None,
    k: npt.ArrayLike | None = None,
) -> Conductor:
    """Describe a rough conductor.

    Args:
        alpha: GGX width in [0.01, 1].
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it.
        r0: reflectance at normal incidence in [0, 1] (Schlick 1994); or give eta and k.
        eta, k: real and imaginary part of the index of refraction, >= 0, relative to air. Under a
            coat they are divided by the coat's index, relative to air; r0 remains.

    Raises:
        ParameterError: a value is out of range, not exactly one kind of Fresnel term is given, or
            neither alpha nor both of alpha_u and alpha_v.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the conductor's")
    return Conductor(width, r0, eta, k)  # type: ignore[arg-type]


class SchlickConductor(Microfacet, kind="conductor"):
    """A GGX conductor with Schlick's Fresnel term (Schlick 1994, equation 24)."""

    parameters = ("alpha", "r0")
    r0: Any

    def reflectance(self, cos_m):
        return fresnel.schlick(cos_m, self.r0)

    @staticmethod
    def fresnel_numbers(columns):
        return columns["r0"], 1.0, 0.0, 1.5, 0.0

    @staticmethod
    def draw(rng, n, draw_eta):
        """R0 = U(0, 1)."""
        return {"alpha": draw_alpha(rng, n), "r0": rng.uniform(0.0, 1.0, n)}


class ComplexConductor(Microfacet, kind="conductor_complex"):
    """A GGX conductor with the exact Fresnel term of a complex index eta - i k."""

    parameters = ("alpha", "eta", "k")
    eta: Any
    k: Any

    def reflectance(self, cos_m):
        return fresnel.exact(cos_m, self.eta, self.k)

    @staticmethod
    def fresnel_numbers(columns):
        return 0.0, 0.0, 1.0, columns["eta"], columns["k"]

    @staticmethod
    def draw(rng, n, draw_eta):
        """eta = U(0.05, 3.5), k = U(0.5, 8), about the range of metals."""
        return {
            "alpha": draw_alpha(rng, n),
            "eta": rng.uniform(0.05, 3.5, n),
            "k": rng.uniform(0.5, 8.0, n),
        }
