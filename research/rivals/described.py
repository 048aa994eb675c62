"""Coats over a bottom that is known by numbers, and the base of the plugins of other models.

Models of other authors add interfaces that are given by numbers. They cannot take any BSDF as a
bottom: it is a `roughconductor` of the GGX distribution and of one width, or a `diffuse`.
"""

from collections.abc import Callable, Sequence
from typing import Any, ClassVar, NamedTuple

import drjit as dr
import mitsuba as mi

from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.core import fresnel
from urushi.errors import ParameterError
from urushi.mitsuba.plugins.stack import CoatStack
from urushi.mitsuba.reading.changed import relative_to
from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.reading.nested import nested_bsdf
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.reading.probing import known_surface
from urushi.mitsuba.reading.ranges import check_coat
from urushi.mitsuba.surface import Surface, surface_of


class BottomNumbers(NamedTuple):
    """The bottom of one channel at a surface interaction.

    Attributes:
        alpha: its GGX width; None: it is Lambertian.
        reflectance: function of the cosine on the facet; a Lambertian surface ignores it.
    """

    alpha: Any
    reflectance: Callable[[Any], Any]


class StackNumbers(NamedTuple):
    """A stack of one channel at a surface interaction: coats, top to bottom, and the bottom."""

    coats: Sequence[CoatParameters]
    bottom: BottomNumbers


class DescribedBottom:
    """A `roughconductor` or a `diffuse` by its textures."""

    def __init__(self, bsdf: "mi.BSDF", where: str, plugin: str):
        """Read the textures.

        Raises:
            ParameterError: the BSDF is another one, or it is anisotropic; begins with `where`.
        """
        self._textures = nested_objects(bsdf)
        while bsdf.class_name() == "TwoSidedBRDF":
            bsdf = self._textures["brdf_0"]
            self._textures = nested_objects(bsdf)
        known = known_surface(bsdf)
        self.is_diffuse = bsdf.class_name() == "SmoothDiffuse"
        if "alpha_u" in self._textures or not (known.lobe_only or self.is_diffuse):
            raise ParameterError(
                f"{where}: the model does not support the nested {bsdf.class_name()}; nest a "
                "'roughconductor' of the distribution 'ggx' with one alpha, a 'diffuse' or "
                f"another '{plugin}', or use the plugin 'layered'"
            )

    def at(self, si, active) -> list[BottomNumbers]:
        """The bottom at a surface interaction, for each channel of the variant's spectrum."""

        def channels(name: str) -> "mi.Spectrum":
            present = name in self._textures
            return mi.Spectrum(self._textures[name].eval(si, active) if present else 1)

        if self.is_diffuse:
            reflectance = dr.clip(channels("reflectance"), 0, 1)
            return [BottomNumbers(None, _constant(value)) for value in reflectance]
        alpha = dr.clip(self._textures["alpha"].eval_1(si, active), MIN_ALPHA, 1)
        names = ("specular_reflectance", "eta", "k")
        return [
            BottomNumbers(alpha, _conductor(dr.clip(factor, 0, 1), eta, k))
            for factor, eta, k in zip(*map(channels, names), strict=True)
        ]


def _constant(value) -> Callable[[Any], Any]:
    """A reflectance that is the same for all angles."""
    return lambda cos: value


def _conductor(factor, eta, k) -> Callable[[Any], Any]:
    """Reflectance of a conductor; Mitsuba's metal "none" has the index 0 and reflects all light."""
    exact = eta > 0

    def reflectance(cos):
        cos = dr.clip(cos, 0, 1)
        return factor * dr.select(exact, fresnel.exact(cos, dr.select(exact, eta, 1), k), 1)

    return reflectance


class DescribedSurface(Surface):
    """Coats over a described bottom; directly nested ones form one stack."""

    PLUGIN: ClassVar[str]  # its name, in errors

    def _load(self, props):
        self._nested = nested_bsdf(props)
        self._coat = CoatTextures(props)
        if self._coat.is_anisotropic or self._coat.has_rotation:
            raise ParameterError(
                f"{self._coat.where}: the model supports isotropic lobes only; give alpha "
                "instead of alpha_u and alpha_v, and no rotation"
            )
        check_coat(self._coat)
        self.coats = [self._coat]
        inner = surface_of(self._nested)
        if isinstance(inner, type(self)):
            own, *others = inner.coats
            self.coats += [own.relative_to(self._coat), *others]
            self.bottom = inner.bottom
        else:
            nested = relative_to(self._nested, self._coat)
            self.bottom = DescribedBottom(nested, self._coat.where, self.PLUGIN)

    def _stacks(self, si, active) -> list[StackNumbers]:
        """The stack at si for each channel of the variant's spectrum."""
        lanes = range(dr.size_v(mi.Spectrum))
        coats = [CoatStack(self.coats, si, active, lane)._coats for lane in lanes]
        return [StackNumbers(*each) for each in zip(coats, self.bottom.at(si, active), strict=True)]

    def traverse(self, callback):
        self._coat.traverse(callback, mi.ParamFlags.NonDifferentiable)
        callback.put("bottom", self._nested, mi.ParamFlags.NonDifferentiable)

    def _update(self, keys):
        self._coat.parameters_changed()
        check_coat(self._coat)

    def to_string(self):
        bottom = str(self._nested).replace("\n", "\n  ")
        return f"{type(self).__name__}[\n{self._coat},\n  bottom = {bottom}\n]"
