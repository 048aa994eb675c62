"""Rough conductors: a GGX surface with Schlick's Fresnel term, or with a complex index.

A GGX surface scatters light once. The option `energy_compensation` gives back what meets a second
facet (`core.facets`).
"""

from dataclasses import dataclass, replace
from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import Widths
from urushi.core import fresnel
from urushi.core.directions import square_to_cosine_hemisphere
from urushi.core.facets import SeenLight, multiple_lobe
from urushi.errors import ParameterError
from urushi.walk.bottoms import bottom


@dataclass(frozen=True)
class Conductor(bottom.Rough, bottom.Description):
    """A rough conductor: GGX of width `alpha`, and Schlick's `r0` or a complex index `eta`, `k`.

    The index is relative to the medium above.
    """

    alpha: bottom.Value | Widths
    r0: bottom.Value | None = None
    eta: bottom.Value | None = None
    k: bottom.Value | None = None
    energy_compensation: bool = False

    def __post_init__(self) -> None:
        bottom.store_alpha(self, self.alpha, "the conductor's")
        if self.r0 is not None and self.eta is None and self.k is None:
            bottom.store(self, "r0", checks.reflectance(self.r0, "the conductor's r0"))
        elif self.r0 is None and self.eta is not None and self.k is not None:
            for name in ("eta", "k"):
                index = checks.nonnegative(getattr(self, name), f"the conductor's {name}")
                bottom.store(self, name, np.minimum(index, checks.MAX_INDEX))
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
        kind = "conductor" if self.r0 is not None else "conductor_complex"
        return kind + "_compensated" * self.energy_compensation


@bottom.maker
def conductor(
    alpha: npt.ArrayLike | None = None,
    r0: npt.ArrayLike | None = None,
    *,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
    eta: npt.ArrayLike | None = None,
    k: npt.ArrayLike | None = None,
    energy_compensation: bool = False,
) -> Conductor:
    """Describe a rough conductor.

    Args:
        alpha: GGX width in [0.01, 1].
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it.
        r0: reflectance at normal incidence in [0, 1] (Schlick 1994); or give eta and k.
        eta, k: real and imaginary part of the index of refraction, >= 0, relative to air. Under a
            coat they are divided by the coat's index, relative to air; r0 remains.
        energy_compensation: whether light that meets a second facet is given back, so that a white
            conductor reflects all light within 0.3 % (`urushi.core.facets`).

    Raises:
        ParameterError: a value is out of range, not exactly one kind of Fresnel term is given, or
            neither alpha nor both of alpha_u and alpha_v.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the conductor's")
    return Conductor(width, r0, eta, k, energy_compensation)  # type: ignore[arg-type]


class SchlickConductor(bottom.Microfacet, kind="conductor"):
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
        return {"alpha": bottom.draw_alpha(rng, n), "r0": rng.uniform(0.0, 1.0, n)}


class ComplexConductor(bottom.Microfacet, kind="conductor_complex"):
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
            "alpha": bottom.draw_alpha(rng, n),
            "eta": rng.uniform(0.05, 3.5, n),
            "k": rng.uniform(0.5, 8.0, n),
        }


class Compensated(bottom.Microfacet):
    """A GGX reflector with the light that meets more than one facet (`core.facets`)."""

    bare = False
    tabulated = True
    draw = staticmethod(bottom.Family.draw)  # training has those of single scattering

    def __init__(self, *values):
        super().__init__(*values)
        self._seen = SeenLight(self.alpha)

    def f_pdf(self, wi, wo):
        f, pdf = super().f_pdf(wi, wo)
        seen, mean = self._seen.of(wi), fresnel.hemisphere_mean(self.reflectance)
        valid = (wi.z > 0) & (wo.z > 0)
        f += dr.select(valid, multiple_lobe(seen, self._seen.of(wo), self._seen.mean, mean), 0)
        return f, dr.select(valid, seen * pdf + (1 - seen) * wo.z * dr.inv_pi, 0)

    def sample(self, wi, u0, u1, u2):
        once, _, _ = super().sample(wi, u0, u1, u2)
        diffuse = square_to_cosine_hemisphere(type(wi), u1, u2)
        wo = dr.select(u0 < self._seen.of(wi), once, diffuse)
        f, pdf = self.f_pdf(wi, wo)
        return wo, dr.select(pdf > 0, f * wo.z / pdf, 0), pdf


class CompensatedSchlick(Compensated, SchlickConductor, kind="conductor_compensated"):
    """`SchlickConductor` with all light."""


class CompensatedComplex(Compensated, ComplexConductor, kind="conductor_complex_compensated"):
    """`ComplexConductor` with all light."""
