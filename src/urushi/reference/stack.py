"""Descriptions of layered materials: immutable values, checked when they are made.

Every parameter is a number or one number per RGB channel, stored as a float or a tuple of three.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import DEFAULT_COAT, CoatParameters
from urushi.errors import ParameterError

#: A number, or one number per RGB channel.
Value = float | tuple[float, float, float]


def _freeze(array: np.ndarray) -> Value:
    if array.ndim == 0:
        return float(array)
    return float(array[0]), float(array[1]), float(array[2])


def _set(instance: object, name: str, array: np.ndarray) -> None:
    object.__setattr__(instance, name, _freeze(array))


@dataclass(frozen=True)
class Conductor:
    """A rough conductor: GGX of width `alpha`, and Schlick's `r0` or a complex index `eta`, `k`."""

    alpha: Value
    r0: Value | None = None
    eta: Value | None = None
    k: Value | None = None

    def __post_init__(self) -> None:
        _set(self, "alpha", checks.alpha(self.alpha, "the conductor's alpha"))
        if self.r0 is not None and self.eta is None and self.k is None:
            _set(self, "r0", checks.reflectance(self.r0, "the conductor's r0"))
        elif self.r0 is None and self.eta is not None and self.k is not None:
            _set(self, "eta", checks.nonnegative(self.eta, "the conductor's eta"))
            _set(self, "k", checks.nonnegative(self.k, "the conductor's k"))
        else:
            raise ParameterError(
                "a conductor needs either r0 (Schlick) or both eta and k (complex index of "
                "refraction)"
            )


@dataclass(frozen=True)
class Dielectric:
    """A rough dielectric interface: GGX of width `alpha`, relative index `eta`.

    `urushi.layer` uses it as a coat. As a bottom it only reflects: the transmitted light is lost.
    """

    alpha: Value = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta

    def __post_init__(self) -> None:
        _set(self, "alpha", checks.alpha(self.alpha, "the dielectric's alpha"))
        _set(self, "eta", checks.eta(self.eta, "the dielectric's eta"))


@dataclass(frozen=True)
class Diffuse:
    """A Lambertian surface of the given `reflectance`."""

    reflectance: Value

    def __post_init__(self) -> None:
        _set(self, "reflectance", checks.reflectance(self.reflectance))


@dataclass(frozen=True)
class Coat:
    """A rough dielectric interface over a homogeneous medium of unit thickness.

    `sigma_t` is the medium's optical depth, `albedo` its single-scattering albedo, `g` the
    asymmetry of its Henyey-Greenstein phase function; `eta` is relative to the medium above.
    """

    alpha: Value = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta
    albedo: Value = DEFAULT_COAT.albedo
    sigma_t: Value = DEFAULT_COAT.sigma_t
    g: Value = DEFAULT_COAT.g

    def __post_init__(self) -> None:
        for name in CoatParameters._fields:
            check = getattr(checks, name)
            _set(self, name, check(getattr(self, name), f"the coat's {name}"))


#: A bottom: a description, or an object with the methods of `bottoms.Bottom`.
BottomDescription = Conductor | Dielectric | Diffuse | object


@dataclass(frozen=True)
class Stack:
    """Coats, top to bottom, over a bottom BRDF, whose values are those in air."""

    coats: tuple[Coat, ...]
    bottom: BottomDescription

    def __post_init__(self) -> None:
        if not self.coats or not all(isinstance(coat, Coat) for coat in self.coats):
            raise ParameterError("a Stack needs one or more Coat objects, top to bottom")
        if isinstance(self.bottom, Conductor | Dielectric | Diffuse):
            return
        if not (hasattr(self.bottom, "f_pdf") and hasattr(self.bottom, "sample")):
            raise ParameterError(
                f"{type(self.bottom).__name__} cannot lie under a coat; give a conductor, "
                "dielectric, diffuse, Stack, or an object with f_pdf and sample on Dr.Jit arrays"
            )


def conductor(
    alpha: npt.ArrayLike,
    r0: npt.ArrayLike | None = None,
    *,
    eta: npt.ArrayLike | None = None,
    k: npt.ArrayLike | None = None,
) -> Conductor:
    """Describe a rough conductor.

    Args:
        alpha: GGX width in [0.01, 1].
        r0: reflectance at normal incidence in [0, 1] (Schlick 1994); or give eta and k.
        eta, k: real and imaginary part of the index of refraction, >= 0, relative to air.

    Raises:
        ParameterError: a value is out of range, or not exactly one kind of Fresnel term is given.
    """
    return Conductor(alpha, r0, eta, k)  # type: ignore[arg-type]


def dielectric(
    alpha: npt.ArrayLike = DEFAULT_COAT.alpha, eta: npt.ArrayLike = DEFAULT_COAT.eta
) -> Dielectric:
    """Describe a rough dielectric interface.

    Args:
        alpha: GGX width in [0.01, 1].
        eta: index relative to the medium above, in [0.5, 3], at least 0.001 away from 1; by default
            that of BK7 glass in air.

    Raises:
        ParameterError: a value is out of range.
    """
    return Dielectric(alpha, eta)  # type: ignore[arg-type]


def diffuse(reflectance: npt.ArrayLike) -> Diffuse:
    """Describe a Lambertian surface of `reflectance` in [0, 1].

    Raises:
        ParameterError: the reflectance is out of range.
    """
    return Diffuse(reflectance)  # type: ignore[arg-type]


def coat(
    bottom: BottomDescription,
    alpha: npt.ArrayLike = DEFAULT_COAT.alpha,
    eta: npt.ArrayLike = DEFAULT_COAT.eta,
    albedo: npt.ArrayLike = DEFAULT_COAT.albedo,
    sigma_t: npt.ArrayLike = DEFAULT_COAT.sigma_t,
    g: npt.ArrayLike = DEFAULT_COAT.g,
) -> Stack:
    """Put a coat on `bottom`; coating a Stack adds the coat on top of its coats.

    Args:
        bottom: a description, a Stack, or an object with `f_pdf` and `sample` on Dr.Jit arrays
            (see `urushi.reference.bottoms.Bottom`).
        alpha: GGX width of the interface in [0.01, 1].
        eta: its index relative to the medium above, in [0.5, 3], at least 0.001 away from 1; by
            default that of BK7 glass in air.
        albedo: single-scattering albedo of the medium below it in [0, 1].
        sigma_t: optical depth of that medium, >= 0.
        g: its Henyey-Greenstein asymmetry in (-1, 1).

    Raises:
        ParameterError: a value is out of range or `bottom` is no BRDF.
    """
    top = Coat(alpha, eta, albedo, sigma_t, g)  # type: ignore[arg-type]
    if isinstance(bottom, Stack):
        return Stack((top, *bottom.coats), bottom.bottom)
    return Stack((top,), bottom)
