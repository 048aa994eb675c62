"""Descriptions of layered materials: immutable values, checked when they are made.

Every parameter is a number or one number per RGB channel, stored as a float or a tuple of three. A
GGX width `alpha` may be two of these, `checks.Widths`, along and across the tangent, which all
layers share. Equal widths are stored as one.
"""

import functools
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import AIR, DEFAULT_COAT, CoatParameters, Widths
from urushi.core.appearance import described
from urushi.core.microfacet import of_widths
from urushi.errors import ParameterError
from urushi.walk.bottoms import MAKERS, Description, Rough, Value
from urushi.walk.bottoms.bottom import store, store_alpha
from urushi.walk.bottoms.dielectric import Dielectric, dielectric


@dataclass(frozen=True)
class Coat(Rough):
    """A rough dielectric interface over a homogeneous medium of unit thickness.

    `sigma_t` is the medium's optical depth, `albedo` its single-scattering albedo, `g` the
    asymmetry of its Henyey-Greenstein phase function; `eta` is relative to the medium above. `ior`
    is the absolute index, if it is known: `eta` then follows the medium above (`Stack.under`).
    """

    alpha: Value | Widths = DEFAULT_COAT.alpha
    eta: Value = DEFAULT_COAT.eta
    albedo: Value = DEFAULT_COAT.albedo
    sigma_t: Value = DEFAULT_COAT.sigma_t
    g: Value = DEFAULT_COAT.g
    ior: Value | None = None
    energy_compensation: bool = False

    def __post_init__(self) -> None:
        store_alpha(self, self.alpha, "the coat's")
        for name in CoatParameters._fields[1:]:
            check = getattr(checks, name)
            store(self, name, check(getattr(self, name), f"the coat's {name}"))
        if self.ior is not None:
            store(self, "ior", np.asarray(self.ior))

    @property
    def parameters(self) -> CoatParameters:
        """The coat as arrays () or (3,)."""
        values = (np.asarray(getattr(self, name)) for name in CoatParameters._fields[1:])
        return CoatParameters(of_widths(np.asarray, self.alpha), *values)


#: A bottom: a `Description`, or an object with the methods of `Bottom`.
BottomDescription = Description | object


@dataclass(frozen=True)
class Stack:
    """Coats, top to bottom, over a bottom BRDF. All indices are relative to the medium above."""

    coats: tuple[Coat, ...]
    bottom: BottomDescription

    @property
    def is_anisotropic(self) -> bool:
        """Whether a described surface has two different widths."""
        return any(
            isinstance(part, Rough | Description) and part.is_anisotropic
            for part in (*self.coats, self.bottom)
        )

    @property
    def index(self) -> np.ndarray:
        """Index of the medium beyond a slab, relative to the medium above it: (3,) or ()."""
        etas = (part.eta for part in (*self.coats, self.bottom))  # type: ignore[attr-defined]
        return functools.reduce(np.multiply, etas)

    def under(self, index: npt.ArrayLike) -> "Stack":
        """The stack below another medium: coats of known absolute indices keep these.

        index: of that medium, relative to the one that lies above the stack now.
        """
        coats: list[Coat] = []
        for coat in self.coats:  # index: of the medium above the coat, relative to what it was
            if coat.ior is not None:
                coat, index = replace(coat, eta=np.divide(coat.eta, index)), 1.0  # type: ignore
            coats.append(coat)
        return Stack(tuple(coats), under(self.bottom, index))

    def __post_init__(self) -> None:
        coats = tuple(self.coats) if isinstance(self.coats, Sequence) else ()
        object.__setattr__(self, "coats", coats)
        if not coats or not all(isinstance(coat, Coat) for coat in coats):
            raise ParameterError("a Stack needs one or more Coat objects, top to bottom")
        if isinstance(self.bottom, Description):
            return
        if not (hasattr(self.bottom, "f_pdf") and hasattr(self.bottom, "sample")):
            raise ParameterError(
                f"{type(self.bottom).__name__} cannot lie under a coat; give a "
                f"{', '.join(MAKERS)}, Stack, or an object with f_pdf and sample on Dr.Jit arrays"
            )


@functools.singledispatch
def under(bottom: Any, index: npt.ArrayLike) -> Any:
    """A Stack or a bottom below a medium (`Stack.under`); measured BRDFs and others as they are.

    `under.register(type, function)` adds a type; `mitsuba.register` adds Mitsuba's BSDFs.
    """
    return bottom.under(index) if isinstance(bottom, Stack | Description) else bottom


def coat(
    bottom: BottomDescription,
    alpha: npt.ArrayLike | None = None,
    eta: npt.ArrayLike | None = None,
    albedo: npt.ArrayLike | None = None,
    sigma_t: npt.ArrayLike | None = None,
    g: npt.ArrayLike = DEFAULT_COAT.g,
    *,
    ior: npt.ArrayLike | None = None,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
    color: npt.ArrayLike | None = None,
    body: npt.ArrayLike | None = None,
    body_color: npt.ArrayLike | None = None,
    thickness: float = 1.0,
    energy_compensation: bool = False,
) -> Stack:
    """Put a coat on `bottom`; coating a Stack adds the coat on top of its coats.

    Indices given as `ior` remain what they are: of two coats of the same index, the lower one has
    no interface. So do `eta` and `k` of a conductor. The Stack holds the ratios of indices.

    Args:
        bottom: a description, a Stack, or an object with `f_pdf` and `sample` on Dr.Jit arrays
            (see `urushi.walk.bottoms.bottom.Bottom`).
        alpha: GGX width of the interface in [0.01, 1], by default 0.1.
        alpha_u, alpha_v: in place of alpha, the widths along the tangent and across it. The tangent
            is the x axis of the directions, for all coats and for the bottom.
        ior: absolute index of refraction of the coat, by default that of BK7 glass, 1.5046. The
            medium above is air, 1.000277, or the next coat. The ratio of both must be in [0.5, 3];
            nearer to 1 than 0.001 it is 1: there is no interface, whatever its width.
        eta: in place of ior, this ratio, whatever the medium above.
        albedo: single-scattering albedo of the medium below it in [0, 1], by default 0.
        sigma_t: optical depth of that medium in [0, 1e6], by default 0.
        g: its Henyey-Greenstein asymmetry in (-1, 1).
        color: in place of albedo and sigma_t, the colour of a clear coat in [0, 1]: what it
            transmits twice at normal incidence, at thickness 1; below 1e-6 it is 1e-6.
        body: with or without color, the opacity of pigment in [0, 1]: the share of diffuse light
            that a white pigment keeps from passing, at thickness 1; above 0.99 it is 0.99. By
            default 1 with body_color, otherwise 0.
        body_color: diffuse reflectance of the pigment in [0, 1] where it is opaque, by default
            0.8. `urushi.core.appearance` has the equations.
        thickness: factor of the optical depth, zero or more.
        energy_compensation: whether light that meets a second facet of the surface is given back,
            so that a white coat over white reflects all light (`urushi.walk.simulate`). The
            option of a coat under another coat has no effect.

    Raises:
        ParameterError: a value is out of range, `bottom` is not a BRDF, alpha is given together
            with alpha_u or alpha_v, or only one of these is given, or eta together with ior, or
            color or body together with albedo or sigma_t; or energy_compensation for a slab.
    """
    width = checks.widths(alpha, alpha_u, alpha_v, "the coat's", DEFAULT_COAT.alpha)
    ratio, ior = checks.eta_in_air(eta, ior, "the coat's")
    look = {"color": color, "body": body, "body_color": body_color}
    medium = described(
        "the coat's", g=g, thickness=thickness, albedo=albedo, sigma_t=sigma_t, **look
    )
    top = Coat(width, ratio, *medium, g, ior, energy_compensation)  # type: ignore[arg-type]
    bottom = under(bottom, top.eta)
    lowest = bottom.bottom if isinstance(bottom, Stack) else bottom
    if energy_compensation and isinstance(lowest, Dielectric):
        raise ParameterError("energy_compensation needs an opaque bottom; leave it out of slabs")
    if isinstance(bottom, Stack):
        return Stack((top, *bottom.coats), bottom.bottom)
    return Stack((top,), bottom)


def slab(
    alpha: npt.ArrayLike | None = None,
    eta: npt.ArrayLike | None = None,
    albedo: npt.ArrayLike | None = None,
    sigma_t: npt.ArrayLike | None = None,
    g: npt.ArrayLike = DEFAULT_COAT.g,
    *,
    ior: npt.ArrayLike | None = None,
    far: Dielectric | None = None,
    alpha_u: npt.ArrayLike | None = None,
    alpha_v: npt.ArrayLike | None = None,
    color: npt.ArrayLike | None = None,
    body: npt.ArrayLike | None = None,
    body_color: npt.ArrayLike | None = None,
    thickness: float = 1.0,
) -> Stack:
    """Describe a layer that transmits light: a coat over its own lower interface.

    It is `coat` over a `urushi.dielectric`; further coats may be put on it.

    Args:
        far: the interface between the medium and what lies beyond, `urushi.dielectric(alpha, ior)`
            with the index beyond, or `eta`, relative to the medium; by default of the same width,
            with air beyond, or with `eta` the medium above.

    The other arguments are those of `coat`.

    Raises:
        ParameterError: a value is out of range, or far is no dielectric.
    """
    if far is None:
        beyond = None if eta is None else np.divide(1.0, checks.eta(eta, "the slab's eta"))
        far = dielectric(
            alpha, beyond, ior=AIR if eta is None else None, alpha_u=alpha_u, alpha_v=alpha_v
        )
    elif not isinstance(far, Dielectric):
        raise ParameterError(
            f"the far side of a slab is a {type(far).__name__}, not an interface; give "
            "urushi.dielectric(alpha, eta), or put a coat on an opaque bottom"
        )
    return coat(
        far,
        *(alpha, eta, albedo, sigma_t, g),
        ior=ior,
        alpha_u=alpha_u,
        alpha_v=alpha_v,
        color=color,
        body=body,
        body_color=body_color,
        thickness=thickness,
    )
