"""Sources of `encode`: whatever has a BRDF, as a function of two directions.

The topmost interface of a description, and a surface that is nothing else, are known exactly: they
are the lobe of the code (`urushi.nets.lobe`).
"""

import functools
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.errors import ParameterError
from urushi.material.material import Material
from urushi.measured import Merl, Rgl
from urushi.nets import lobe as lobes
from urushi.walk import Stack, analytic
from urushi.walk.bottoms import Description
from urushi.walk.bottoms.dielectric import Dielectric
from urushi.walk.simulate import albedo, simulate

#: Random walks per probe and channel for a Stack: about 0.5 % noise where f is not tiny.
STACK_WALKS = 16384

#: An evaluated BRDF: f(wi, wo) -> (N, 3), (N, C) or (N,) [1/sr] for float32 unit vectors (N, 3).
Brdf = Callable[[np.ndarray, np.ndarray], Any]


class Source(NamedTuple):
    """A BRDF to be encoded."""

    f: Brdf  # is evaluated at pairs above the horizon
    symmetric: bool = False  # whether f is isotropic and reciprocal by construction
    noisy: bool = False  # whether f draws random numbers, which hide its asymmetry
    # Whether a material has a table by default. Codes of lobes alone and of Lambertians are exact;
    # random walks are too noisy and cost too much.
    tabulated: bool = True
    # Shares of the light, in [0, 1], that f does not contain.
    transmitted: float = 0.0
    mirrored: float = 0.0  # reflected by a perfectly smooth surface
    textured: bool = False  # whether f is taken at one point of a texture
    # (6,) or (C, 6) the analytic lobe of each channel (`urushi.nets.lobe`): the reflection of the
    # topmost interface. None: it is fitted to the values.
    lobe: np.ndarray | None = None
    bare: bool = False  # whether f is its lobe and nothing else
    isotropic: bool = False  # whether f is isotropic by construction, up to its mirror image
    widths: int = 1  # 2: f is anisotropic by construction; symmetric is about its two planes


@functools.singledispatch
def as_source(source: Any) -> Source:
    """A source of `encode` as a function that can be evaluated.

    `as_source.register(type, function)` adds a type of source; `mitsuba.register` adds Mitsuba's
    BSDFs.

    Raises:
        ParameterError: the source cannot be encoded.
    """
    for f in (getattr(source, "f", None), source):
        if callable(f) and not isinstance(source, type):
            return Source(f)
    raise ParameterError(
        f"cannot encode {type(source).__name__}; give a conductor, dielectric, diffuse, Stack, "
        "Material, measured or Mitsuba BRDF, or a function f(wi, wo) -> (N, 3)"
    )


@as_source.register
def _(source: Source) -> Source:
    return source


@as_source.register
def _(source: Material) -> Source:
    lobe = source.latents[:, : source.model.arch.lobe]
    return Source(source.f, symmetric=True, lobe=lobe, widths=source.model.widths)


@as_source.register
def _(source: Merl) -> Source:
    return Source(source.f, symmetric=True)


@as_source.register
def _(source: Rgl) -> Source:
    return Source(source.f, isotropic=source.isotropic)


@as_source.register
def _(source: Description) -> Source:
    kind = source.as_kind()
    fresnel, alpha = kind.family.fresnel_numbers(vars(source)), getattr(source, "alpha", None)
    lobe = (
        None if fresnel is None else _lobe(lobes.NO_LOBE[0] if alpha is None else alpha, *fresnel)
    )
    return Source(
        functools.partial(analytic.f, source),
        symmetric=True,
        tabulated=lobe is None or kind.family.tabulated,
        lobe=lobe,
        bare=kind.family.bare,
        widths=kind.widths,
    )


@as_source.register
def _(source: Stack) -> Source:
    top, transmitted = source.coats[0], 0.0
    if isinstance(source.bottom, Dielectric):
        transmitted = albedo(source, [[0.0, 0.0, 1.0]], walks=4096, transmitted=True)[0].mean()
    lobe = None  # if there is no interface, it is one from below
    if not np.all(np.equal(top.eta, 1)):
        lobe = _lobe(top.alpha, 0.0, 0.0, 1.0, top.eta, 0.0)
    return Source(
        lambda wi, wo: simulate(source, wi, wo, walks=STACK_WALKS, seed=0)[0],
        symmetric=True,
        tabulated=False,
        transmitted=float(transmitted),
        lobe=lobe,
        widths=2 if source.is_anisotropic else 1,
    )


def _lobe(alpha: Any, *numbers: npt.ArrayLike) -> np.ndarray:
    """The lobe float32 (..., N) of a width or two `Widths`, and five numbers that broadcast."""
    if isinstance(alpha, checks.Widths):
        alpha, numbers = alpha.u, (*numbers, alpha.v)
    return np.stack(np.broadcast_arrays(alpha, *numbers), axis=-1).astype(np.float32)


def source_name(source: Any) -> str:
    """The name of a source in messages."""
    return getattr(source, "__name__", type(source).__name__)
