"""The Lambertian surface."""

from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy.typing as npt

from urushi import checks
from urushi.core.directions import square_to_cosine_hemisphere
from urushi.walk.bottoms.bottom import Description, Family, Value, maker, store


@dataclass(frozen=True)
class Diffuse(Description):
    """A Lambertian surface of the given `reflectance`."""

    kind = "diffuse"
    reflectance: Value

    def __post_init__(self) -> None:
        store(self, "reflectance", checks.reflectance(self.reflectance))


@maker
def diffuse(reflectance: npt.ArrayLike) -> Diffuse:
    """Describe a Lambertian surface of `reflectance` in [0, 1].

    Raises:
        ParameterError: the reflectance is out of range.
    """
    return Diffuse(reflectance)  # type: ignore[arg-type]


class Lambertian(Family, kind="diffuse"):
    """Ideal diffuse reflection: f = reflectance / pi."""

    parameters = ("reflectance",)
    reflectance: Any

    def f_pdf(self, wi, wo):
        valid = (wi.z > 0) & (wo.z > 0)
        return (
            self.reflectance * dr.select(valid, dr.inv_pi, 0),
            dr.select(valid, wo.z * dr.inv_pi, 0),
        )

    def sample(self, wi, u0, u1, u2):
        wo = square_to_cosine_hemisphere(type(wi), u1, u2)
        return wo, self.reflectance, wo.z * dr.inv_pi

    @staticmethod
    def fresnel_numbers(columns):
        return 0.0, 0.0, 0.0, 1.5, 0.0

    @staticmethod
    def draw(rng, n, draw_eta):
        """reflectance = U(0, 1)."""
        return {"reflectance": rng.uniform(0.0, 1.0, n)}
