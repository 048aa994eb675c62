"""The rough dielectric interface, as a coat's surface or as the lowest interface of a slab."""

from dataclasses import dataclass

import numpy.typing as npt

from urushi import checks
from urushi.checks import DEFAULT_COAT, Widths
from urushi.core import fresnel
from urushi.walk.bottoms.bottom import (
    Description,
    Rough,
    Value,
    draw_alpha,
    maker,
    store,
    store_alpha,
)
from urushi.walk.bottoms.microfacet import Microfacet


@dataclass(frozen=True)
class Dielectric(Rough, Description):
    """A rough dielectric interface: GGX of width `alpha`, relative index `eta`.

    `urushi.layer` uses it as a coat. A stack over it is a slab, which transmits (`urushi.slab`).
    Materials have its reflection alone.
    """

    alpha: Value | Widths = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta

    def __post_init__(self) -> None:
        store_alpha(self, self.alpha, "the dielectric's")
        store(self, "eta", checks.eta(self.eta, "the dielectric's eta"))

    @property
    def kind(self) -> str:
        return "dielectric"


@maker
def dielectric(
    alpha: npt.ArrayLike | None = None,
    eta: npt.ArrayLike = DEFAULT_COAT.eta,
    *,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
) -> Dielectric:
    """Describe a rough dielectric interface.

    Args:
        alpha: GGX width in [0.01, 1], by default 0.1.
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it.
        eta: index relative to the medium above, in [0.5, 3], by default that of BK7 glass in air.
            Nearer to 1 than 0.001 it is 1, without an interface.

    Raises:
        ParameterError: a value is out of range, alpha is given together with alpha_u or alpha_v, or
            only one of these is given.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the dielectric's", DEFAULT_COAT.alpha)
    return Dielectric(width, eta)  # type: ignore[arg-type]


class Reflector(Microfacet, kind="dielectric"):
    """The reflection of a rough dielectric."""

    parameters = ("alpha", "eta")
    title = "dielectric reflector"

    def __init__(self, alpha, eta):
        super().__init__(alpha)
        self.eta = eta

    def reflectance(self, cos_m):
        return fresnel.dielectric(cos_m, self.eta)[0]

    @staticmethod
    def fresnel_numbers(columns):
        return 0.0, 0.0, 1.0, columns["eta"], 0.0

    @staticmethod
    def draw(rng, n, draw_eta):
        """The index is drawn like those of coats."""
        return {"alpha": draw_alpha(rng, n), "eta": draw_eta(rng, n)}
