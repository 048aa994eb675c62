"""A stack's description as the different monochrome stacks that its channels are."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from urushi.errors import ParameterError
from urushi.reference.adding_doubling import surfaces
from urushi.reference.adding_doubling.quadrature import Kernel
from urushi.reference.stack import BottomDescription, Conductor, Dielectric, Diffuse, Stack, Value


@dataclass(frozen=True)
class Layer:
    """One coat of one channel; the fields are those of `urushi.reference.Coat`."""

    alpha: float
    eta: float
    albedo: float
    sigma_t: float
    g: float


@dataclass(frozen=True)
class Monochrome:
    """What one or more of the three channels see.

    Attributes:
        channels: their numbers.
        layers: the coats, top to bottom.
        bottom: kernel of the bottom BRDF.
    """

    channels: list[int]
    layers: list[Layer]
    bottom: Kernel


def split(stack: Stack) -> list[Monochrome]:
    """The different channels of a stack; equal ones come together.

    Raises:
        ParameterError: the bottom is not one of this package's descriptions.
    """
    make, parameters = _bottom(stack.bottom)
    columns: list[Value] = [
        value for c in stack.coats for value in (c.alpha, c.eta, c.albedo, c.sigma_t, c.g)
    ]
    table = np.stack([np.broadcast_to(value, 3) for value in columns + parameters])
    values, inverse = np.unique(table, axis=1, return_inverse=True)
    coated = len(columns)
    return [
        Monochrome(
            np.flatnonzero(inverse.ravel() == number).tolist(),
            [Layer(*map(float, column[k : k + 5])) for k in range(0, coated, 5)],
            make(*map(float, column[coated:])),
        )
        for number, column in enumerate(values.T)
    ]


def _bottom(bottom: BottomDescription) -> tuple[Callable[..., Kernel], list[Value]]:
    """The maker of a bottom's kernel and the parameters that it takes, per channel."""
    match bottom:
        case Diffuse(reflectance):
            return surfaces.lambertian, [reflectance]
        case Dielectric(alpha, eta):
            return surfaces.outer_reflection, [alpha, eta]
        case Conductor(alpha, float() | tuple() as r0):
            return surfaces.conductor_schlick, [alpha, r0]
        case Conductor(alpha, None, float() | tuple() as eta, float() | tuple() as k):
            return surfaces.conductor_complex, [alpha, eta, k]
    raise ParameterError(
        f"adding-doubling knows no kernel of a {type(bottom).__name__} bottom; "
        "give a conductor, dielectric or diffuse"
    )
