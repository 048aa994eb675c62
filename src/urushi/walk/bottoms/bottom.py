"""The walk's protocol of bottoms, their descriptions, and the registry of their families.

A *description* is a frozen dataclass whose values a user gives. A *family* is a BRDF on Dr.Jit
arrays whose parameters are one number per lane. Both register themselves when they are defined.
"""

from collections.abc import Callable, Iterator
from typing import Any, ClassVar, NamedTuple, Protocol

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import MIN_ALPHA, Widths
from urushi.core import microfacet
from urushi.core.directions import reflect

#: A number, or one number per RGB channel.
Value = float | tuple[float, float, float]

#: Random indices of refraction: a function of a generator and a shape.
DrawEta = Callable[[np.random.Generator, Any], np.ndarray]


class Bottom(Protocol):
    """The BRDF under the lowest medium, as the random walk uses it.

    Values are Dr.Jit floats or colours.
    """

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        """BRDF [1/sr] and the density of `sample` at wo, both zero below the horizon."""

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        """Draw wo by three uniform numbers; returns (wo, weight, pdf).

        weight = f cos / pdf; it is 0 if the sample fails.
        """


class Family:
    """Base of the BRDFs that a table of stacks may have as bottoms.

    Subclasses with the keyword `kind` are listed in `KINDS`. Their constructor takes the
    `parameters` in order. If some end with "alpha", the kind "..._anisotropic" has two widths in
    place of each.
    """

    parameters: ClassVar[tuple[str, ...]]  # their names
    bare: ClassVar[bool] = False  # whether the BRDF is one GGX lobe and nothing else
    # Whether materials have a table by default although the lobe is known: codes are less exact.
    tabulated: ClassVar[bool] = False

    def __init__(self, *values: Any) -> None:
        """values: of the parameters, which become attributes."""
        vars(self).update(zip(self.parameters, values, strict=True))

    def __init_subclass__(cls, kind: str = "", **others: Any) -> None:
        super().__init_subclass__(**others)
        if not kind:
            return
        KINDS[kind] = Kind(kind, cls, cls.parameters)
        if any(name.endswith("alpha") for name in cls.parameters):
            names = (
                (f"{name}_u", f"{name}_v") if name.endswith("alpha") else (name,)
                for name in cls.parameters
            )
            twin = f"{kind}_anisotropic"
            KINDS[twin] = Kind(twin, cls, tuple(name for part in names for name in part), 2)

    @staticmethod
    def fresnel_numbers(columns: dict[str, Any]) -> tuple[Any, Any, Any, Any, Any] | None:
        """The Fresnel term of the lobe that the BRDF has, from its parameters.

        Returns:
            (normal, grazing, exact, eta, k) of F(c) = normal (1 - (1 - c)^5) + grazing (1 - c)^5 +
            exact F(c; eta, k); all factors are 0 if there is no lobe. None: `encode` fits a lobe
            to values.
        """

    @staticmethod
    def draw(rng: np.random.Generator, n: int, draw_eta: DrawEta) -> dict[str, np.ndarray]:
        """Draw the parameters of n bottoms of one width for training, float64 (n,) by name."""
        raise NotImplementedError


class Kind(NamedTuple):
    """A family with one width for each of its GGX lobes, or with two."""

    name: str
    family: type[Family]
    parameters: tuple[str, ...]  # names of the columns of a table, in the order of stored data
    widths: int = 1

    def bottom(self, *values: Any) -> Bottom:
        """The BRDF of these parameters."""
        named = dict(zip(self.parameters, values, strict=True))
        for name in self.family.parameters:
            if name not in named:
                named[name] = Widths(named[f"{name}_u"], named[f"{name}_v"])
        return self.family(*(named[name] for name in self.family.parameters))  # type: ignore


#: All kinds of bottoms by name.
KINDS: dict[str, Kind] = {}


class Description:
    """Base of the frozen dataclasses that describe a bottom."""

    @property
    def kind(self) -> str:
        """The kind of the BRDF apart from its number of widths, a key of `KINDS`."""
        raise NotImplementedError

    @property
    def is_anisotropic(self) -> bool:
        """Whether the BRDF has two different widths."""
        return False

    def under(self, index: npt.ArrayLike) -> "Description":
        """The BRDF below a medium, by default the same.

        index: of that medium, relative to the one that lies above the BRDF now.
        """
        return self

    def as_kind(self) -> Kind:
        """The kind of the BRDF."""
        return KINDS[self.kind + "_anisotropic" * self.is_anisotropic]


#: Functions of the public interface that make a description, by name.
MAKERS: dict[str, Any] = {}


def maker(function: Any) -> Any:
    """Register a function that makes a description; descriptions in text call it."""
    MAKERS[function.__name__] = function
    return function


class Rough:
    """A description of a GGX surface."""

    alpha: Value | Widths

    @property
    def alpha_u(self) -> Value:
        """The GGX width along the tangent (the x axis)."""
        return microfacet.pair(self.alpha)[0]

    @property
    def alpha_v(self) -> Value:
        """The GGX width across the tangent (along the y axis)."""
        return microfacet.pair(self.alpha)[1]

    @property
    def is_anisotropic(self) -> bool:
        """Whether the two widths differ in a channel."""
        return isinstance(self.alpha, Widths)


def numbers_of(part: object) -> Iterator[object]:
    """The parameters of a description, both widths among them."""
    for value in vars(part).values():
        yield from (value.u, value.v) if isinstance(value, Widths) else (value,)


def _freeze(array: np.ndarray) -> Value:
    numbers: Any = array.tolist()
    return tuple(numbers) if array.ndim else numbers


def store(instance: object, name: str, array: np.ndarray) -> None:
    """Set a parameter of a frozen description to a checked value."""
    object.__setattr__(instance, name, _freeze(array))


def store_alpha(instance: object, alpha: Value | Widths, where: str) -> None:
    """Check and set the GGX width or widths of a description; equal widths are stored as one."""
    u, v = np.broadcast_arrays(*microfacet.pair(checks.alphas(alpha, f"{where} alpha")))
    stored = _freeze(u) if np.array_equal(u, v) else Widths(_freeze(u), _freeze(v))
    object.__setattr__(instance, "alpha", stored)


def draw_alpha(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """U(0.01^(1/3), 1)^3, in [0.01, 1]."""
    return np.maximum(rng.uniform(MIN_ALPHA ** (1 / 3), 1.0, shape) ** 3, MIN_ALPHA)


class Microfacet(Family):
    """A GGX reflector of one width or two `Widths`."""

    bare: ClassVar[bool] = True
    alpha: Any

    def reflectance(self, cos_m: Any) -> Any:
        """The Fresnel reflectance, a float or colour, at the cosine wi.m >= 0."""
        raise NotImplementedError

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        lobe, cos_m = microfacet.reflection_lobe(wi, wo, self.alpha)
        pdf = lobe * wo.z / microfacet.smith_g1(wo, self.alpha)
        return lobe * self.reflectance(dr.abs(cos_m)), dr.select(lobe > 0, pdf, 0)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        m = microfacet.sample_visible_normal(wi, self.alpha, u1, u2)
        cos_m = dr.dot(wi, m)
        wo = reflect(wi, m)
        g1 = microfacet.smith_g1(wo, self.alpha)
        pdf = microfacet.visible_normal_pdf(wi, m, self.alpha) / (4 * cos_m)
        valid = wo.z > 0
        weight = self.reflectance(dr.abs(cos_m)) * dr.select(valid, g1, 0)
        return wo, weight, dr.select(valid, pdf, 0)
