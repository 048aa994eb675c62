"""Descriptions of layered materials: immutable values, checked when they are made.

Every parameter is a number or one number per RGB channel, stored as a float or a tuple of three. A
GGX width `alpha` may be two of these, `checks.Widths`, along and across the tangent, which all
layers share. Equal widths are stored as one.
"""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import DEFAULT_COAT, CoatParameters, Widths
from urushi.errors import ParameterError

#: A number, or one number per RGB channel.
Value = float | tuple[float, float, float]


def _freeze(array: np.ndarray) -> Value:
    if array.ndim == 0:
        return float(array)
    return float(array[0]), float(array[1]), float(array[2])


def _set(instance: object, name: str, array: np.ndarray) -> None:
    object.__setattr__(instance, name, _freeze(array))


def _set_alpha(instance: object, alpha: Value | Widths, where: str) -> None:
    """Check and store the GGX width or widths of a description."""
    stored: Value | Widths
    if isinstance(alpha, Widths):
        u, v = (
            checks.alpha(width, f"{where} {name}")
            for width, name in ((alpha.u, "alpha_u"), (alpha.v, "alpha_v"))
        )
        u, v = np.broadcast_arrays(u, v)
        stored = _freeze(u) if np.array_equal(u, v) else Widths(_freeze(u), _freeze(v))
    else:
        stored = _freeze(checks.alpha(alpha, f"{where} alpha"))
    object.__setattr__(instance, "alpha", stored)


class Rough:
    """A description of a GGX surface."""

    alpha: Value | Widths

    @property
    def alpha_u(self) -> Value:
        """The GGX width along the tangent (the x axis)."""
        return self.alpha.u if isinstance(self.alpha, Widths) else self.alpha

    @property
    def alpha_v(self) -> Value:
        """The GGX width across the tangent (along the y axis)."""
        return self.alpha.v if isinstance(self.alpha, Widths) else self.alpha

    @property
    def is_anisotropic(self) -> bool:
        """Whether the two widths differ in a channel."""
        return isinstance(self.alpha, Widths)


@dataclass(frozen=True)
class Conductor(Rough):
    """A rough conductor: GGX of width `alpha`, and Schlick's `r0` or a complex index `eta`, `k`."""

    alpha: Value | Widths
    r0: Value | None = None
    eta: Value | None = None
    k: Value | None = None

    def __post_init__(self) -> None:
        _set_alpha(self, self.alpha, "the conductor's")
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
class Dielectric(Rough):
    """A rough dielectric interface: GGX of width `alpha`, relative index `eta`.

    `urushi.layer` uses it as a coat. As a bottom it only reflects: the transmitted light is lost.
    """

    alpha: Value | Widths = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta

    def __post_init__(self) -> None:
        _set_alpha(self, self.alpha, "the dielectric's")
        _set(self, "eta", checks.eta(self.eta, "the dielectric's eta"))


@dataclass(frozen=True)
class Diffuse:
    """A Lambertian surface of the given `reflectance`."""

    reflectance: Value

    def __post_init__(self) -> None:
        _set(self, "reflectance", checks.reflectance(self.reflectance))


@dataclass(frozen=True)
class Coat(Rough):
    """A rough dielectric interface over a homogeneous medium of unit thickness.

    `sigma_t` is the medium's optical depth, `albedo` its single-scattering albedo, `g` the
    asymmetry of its Henyey-Greenstein phase function; `eta` is relative to the medium above.
    """

    alpha: Value | Widths = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta
    albedo: Value = DEFAULT_COAT.albedo
    sigma_t: Value = DEFAULT_COAT.sigma_t
    g: Value = DEFAULT_COAT.g

    def __post_init__(self) -> None:
        _set_alpha(self, self.alpha, "the coat's")
        for name in CoatParameters._fields[1:]:
            check = getattr(checks, name)
            _set(self, name, check(getattr(self, name), f"the coat's {name}"))


#: A bottom: a description, or an object with the methods of `bottoms.Bottom`.
BottomDescription = Conductor | Dielectric | Diffuse | object


@dataclass(frozen=True)
class Stack:
    """Coats, top to bottom, over a bottom BRDF, which is the same as in air."""

    coats: tuple[Coat, ...]
    bottom: BottomDescription

    @property
    def is_anisotropic(self) -> bool:
        """Whether a described surface has two different widths."""
        return any(
            isinstance(part, Rough) and part.is_anisotropic for part in (*self.coats, self.bottom)
        )

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
        eta, k: real and imaginary part of the index of refraction, >= 0, relative to air.

    Raises:
        ParameterError: a value is out of range, not exactly one kind of Fresnel term is given, or
            neither alpha nor both of alpha_u and alpha_v.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the conductor's")
    return Conductor(width, r0, eta, k)  # type: ignore[arg-type]


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
        eta: index relative to the medium above, in [0.5, 3], at least 0.001 away from 1; by default
            that of BK7 glass in air.

    Raises:
        ParameterError: a value is out of range, alpha is given together with alpha_u or alpha_v, or
            only one of these is given.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the dielectric's", DEFAULT_COAT.alpha)
    return Dielectric(width, eta)  # type: ignore[arg-type]


def diffuse(reflectance: npt.ArrayLike) -> Diffuse:
    """Describe a Lambertian surface of `reflectance` in [0, 1].

    Raises:
        ParameterError: the reflectance is out of range.
    """
    return Diffuse(reflectance)  # type: ignore[arg-type]


def coat(
    bottom: BottomDescription,
    alpha: npt.ArrayLike | None = None,
    eta: npt.ArrayLike = DEFAULT_COAT.eta,
    albedo: npt.ArrayLike = DEFAULT_COAT.albedo,
    sigma_t: npt.ArrayLike = DEFAULT_COAT.sigma_t,
    g: npt.ArrayLike = DEFAULT_COAT.g,
    *,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
) -> Stack:
    """Put a coat on `bottom`; coating a Stack adds the coat on top of its coats.

    Args:
        bottom: a description, a Stack, or an object with `f_pdf` and `sample` on Dr.Jit arrays
            (see `urushi.walk.bottoms.Bottom`).
        alpha: GGX width of the interface in [0.01, 1], by default 0.1.
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it. The tangent
            is the x axis of the directions, for all coats and for the bottom.
        eta: its index relative to the medium above, in [0.5, 3], at least 0.001 away from 1; by
            default that of BK7 glass in air.
        albedo: single-scattering albedo of the medium below it in [0, 1].
        sigma_t: optical depth of that medium in [0, 1e6].
        g: its Henyey-Greenstein asymmetry in (-1, 1).

    Raises:
        ParameterError: a value is out of range, `bottom` is not a BRDF, alpha is given together
            with alpha_u or alpha_v, or only one of these is given.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the coat's", DEFAULT_COAT.alpha)
    top = Coat(width, eta, albedo, sigma_t, g)  # type: ignore[arg-type]
    if isinstance(bottom, Stack):
        return Stack((top, *bottom.coats), bottom.bottom)
    return Stack((top,), bottom)
