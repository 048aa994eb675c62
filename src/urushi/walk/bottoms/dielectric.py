"""The rough dielectric interface, as a coat's surface or as the lowest interface of a slab."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import DEFAULT_COAT, LEAST_ETA_BELOW, Widths
from urushi.core import fresnel
from urushi.walk.bottoms import bottom


@dataclass(frozen=True)
class Dielectric(bottom.Rough, bottom.Description):
    """A rough dielectric interface: GGX of width `alpha`, relative index `eta`.

    `urushi.layer` uses it as a coat. A stack over it is a slab, which transmits (`urushi.slab`).
    Materials have its reflection alone.
    `ior` is the absolute index, if it is known: `eta` then follows the medium above (`under`).
    """

    kind = "dielectric"
    alpha: bottom.Value | Widths = DEFAULT_COAT.alpha
    eta: bottom.Value = DEFAULT_COAT.eta
    ior: bottom.Value | None = None

    def __post_init__(self) -> None:
        bottom.store_alpha(self, self.alpha, "the dielectric's")
        eta = checks.eta(self.eta, "the dielectric's eta", low=LEAST_ETA_BELOW)
        bottom.store(self, "eta", eta)
        if self.ior is not None:
            bottom.store(self, "ior", np.asarray(self.ior))

    def under(self, index: npt.ArrayLike) -> "Dielectric":
        return self if self.ior is None else replace(self, eta=np.divide(self.eta, index))  # type: ignore


@bottom.maker
def dielectric(
    alpha: npt.ArrayLike | None = None,
    eta: npt.ArrayLike | None = None,
    *,
    ior: npt.ArrayLike | None = None,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
) -> Dielectric:
    """Describe a rough dielectric interface.

    Args:
        alpha: GGX width in [0.01, 1], by default 0.1.
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it.
        ior: absolute index of refraction, by default that of BK7 glass, 1.5046. The medium above is
            air, 1.000277, or the coat above. Their ratio must be in [1/3, 3], of coats in
            [0.5, 3]; nearer to 1 than 0.001 it is 1, without an interface.
        eta: in place of ior, this ratio, whatever the medium above.

    Raises:
        ParameterError: a value is out of range, alpha is given together with alpha_u or alpha_v, or
            only one of these is given, or eta together with ior.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the dielectric's", DEFAULT_COAT.alpha)
    index = checks.eta_in_air(eta, ior, "the dielectric's", LEAST_ETA_BELOW)
    return Dielectric(width, *index)  # type: ignore[arg-type]


class Reflector(bottom.Microfacet, kind="dielectric"):
    """The reflection of a rough dielectric."""

    parameters = ("alpha", "eta")
    eta: Any

    def reflectance(self, cos_m):
        return fresnel.dielectric(cos_m, self.eta)[0]

    @staticmethod
    def fresnel_numbers(columns):
        return 0.0, 0.0, 1.0, columns["eta"], 0.0

    @staticmethod
    def draw(rng, n, draw_eta):
        """Indices have the distribution of coats."""
        return {"alpha": bottom.draw_alpha(rng, n), "eta": draw_eta(rng, n)}
