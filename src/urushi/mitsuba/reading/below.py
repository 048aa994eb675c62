"""Mitsuba BSDFs below the medium of a coat.

Indices of refraction become relative to that medium. Of Mitsuba's dielectrics, one becomes the
lower interface of a slab, or a pane in air.
"""

import itertools
from functools import cache
from typing import Any, ClassVar, Protocol, runtime_checkable

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.checks import AIR, MIN_ALPHA, MIN_INDEX_STEP, Widths
from urushi.core import fresnel
from urushi.core.direction_sets import cosine_pairs
from urushi.errors import ParameterError
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import NORMALS, nested_objects
from urushi.mitsuba.reading.offers import GGX, Offer, conductor_offer
from urushi.mitsuba.reading.parameters import CoatTextures, opaque

#: Classes of Mitsuba's BSDFs that reflect as the BSDFs nested in them, and their plugins.
WRAPPERS = NORMALS | {"BlendBSDF": "blendbsdf"}

#: Properties of `normalmap` and `bumpmap` that they do not list, by default true, and the number of
#: pairs at which they are found.
SWITCHES, SWITCH_PAIRS = ("use_shadowing_function", "flip_invalid_normals"), 1024


@runtime_checkable
class Coatable(Protocol):
    """A BSDF of this package that changes below a medium."""

    def under(self, coat: CoatTextures) -> "mi.BSDF":
        """The BSDF below the medium of a coat, of the same textures."""


class Medium:
    """A medium of a constant index relative to air, in place of the coat that contains it."""

    has_textured_eta = False

    def __init__(self, index: npt.ArrayLike):
        """index: a number, or one per channel."""
        self.opaque_eta = (mi.Float if np.ndim(index) == 0 else mi.Spectrum)(index)

    def inside(self, si, active=True) -> Any:
        """See `CoatTextures.inside`."""
        return self.opaque_eta


def bsdf_under(bsdf: "mi.BSDF", index: npt.ArrayLike) -> "mi.BSDF":
    """A BSDF below a medium; see `urushi.walk.stack.under`."""
    return below(bsdf, Medium(index))


def below(bsdf: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """A BSDF as it reflects below the medium of a coat, `CoatTextures` or a `Medium`.

    Coats without `ext_ior`, and saved materials that were layered, keep their absolute indices. The
    index of a `roughconductor` is divided by the medium's, relative to air. So it is for those
    within Mitsuba's `twosided`, `blendbsdf`, `normalmap` and `bumpmap`. All others, such as
    measured BRDFs, are as they are in air.
    """
    if isinstance(bsdf, Coatable):
        return bsdf.under(coat)
    name = bsdf.class_name()
    if name == "RoughConductor":
        return _conductor_below(mi.variant())(bsdf, coat)
    if name == "TwoSidedBRDF":
        front = nested_objects(bsdf)["brdf_0"]
        found = below(front, coat)
        return bsdf if found is front else found
    return _wrapper_below(bsdf, coat) if name in WRAPPERS else bsdf


def is_rebuilt(bsdf: "mi.BSDF") -> bool:
    """Whether a result of `below` has to be made again after a change of a parameter."""
    if bsdf.class_name() in WRAPPERS:
        return any(map(is_rebuilt, _nested(bsdf).values()))
    return isinstance(bsdf, Coatable)


def _nested(bsdf: "mi.BSDF") -> dict[str, "mi.BSDF"]:
    parts = nested_objects(bsdf)
    return {name: part for name, part in parts.items() if isinstance(part, mi.BSDF)}


def _wrapper_below(wrapper: "mi.BSDF", coat: Any) -> "mi.BSDF":
    """One of `WRAPPERS` around its nested BSDFs below a medium; itself if they stay the same."""
    nested = _nested(wrapper)
    changed = {id(bsdf): below(bsdf, coat) for bsdf in nested.values()}
    if all(changed[id(bsdf)] is bsdf for bsdf in nested.values()):
        return wrapper
    given = nested_objects(wrapper) | {"type": WRAPPERS[wrapper.class_name()]}
    if given["type"] == "bumpmap":
        given["scale"] = mi.traverse(wrapper)["scale"]
    if given["type"] in NORMALS.values():
        given |= _switches(wrapper, given)
    return mi.load_dict(given | {name: changed[id(bsdf)] for name, bsdf in nested.items()})


def _switches(wrapper: "mi.BSDF", given: dict[str, Any]) -> dict[str, bool]:
    """The switches of a `normalmap` or `bumpmap`, which it does not list among its parameters.

    They are those with which it reflects as it does.

    given: its properties without them.
    """
    rng = np.random.default_rng(0)
    pairs = *cosine_pairs(rng, SWITCH_PAIRS), rng.random((SWITCH_PAIRS, 2))
    f = probing.bsdf_values(wrapper, *pairs)
    for on in itertools.product((True, False), repeat=len(SWITCHES)):
        switches = dict(zip(SWITCHES, on, strict=True))
        found = probing.bsdf_values(mi.load_dict(given | switches), *pairs)
        if np.allclose(found, f, rtol=1e-3):
            break
    return switches


@cache
def _conductor_below(variant: str) -> type:
    """The class of conductors below a medium, in a variant."""

    class ConductorBelow(mi.BSDF):
        """A `roughconductor` below a medium: its f times the ratio of two Fresnel terms."""

        def __init__(self, conductor, coat):
            self.conductor, self.coat = conductor, coat
            self._textures = nested_objects(conductor)
            mi.BSDF.__init__(self, mi.Properties("roughconductor"))
            self.m_components = [conductor.flags(i) for i in range(conductor.component_count())]
            self.m_flags = conductor.flags()

        def offer(self) -> Offer:
            return conductor_offer(self.conductor, self.coat)

        def _ratio(self, si, wo, active) -> Any:
            """Fresnel term below the medium over that in air."""
            cosine = dr.clip(dr.dot(si.wi, dr.normalize(si.wi + wo)), 0, 1)
            eta, k = (self._textures[name].eval(si, active) for name in ("eta", "k"))
            index = self.coat.inside(si, active)
            air = fresnel.exact(cosine, eta, k)
            ratio = fresnel.exact(cosine, eta / index, k / index) / air
            return mi.Spectrum(dr.select(air > 0, ratio, 0))

        def eval(self, ctx, si, wo, active=True):
            return self.conductor.eval(ctx, si, wo, active) * self._ratio(si, wo, active)

        def pdf(self, ctx, si, wo, active=True):
            return self.conductor.pdf(ctx, si, wo, active)

        def eval_pdf(self, ctx, si, wo, active=True):
            f_cos, pdf = self.conductor.eval_pdf(ctx, si, wo, active)
            return f_cos * self._ratio(si, wo, active), pdf

        def sample(self, ctx, si, sample1, sample2, active=True):
            bs, weight = self.conductor.sample(ctx, si, sample1, sample2, active)
            return bs, dr.select(bs.pdf > 0, weight * self._ratio(si, bs.wo, active), 0)

        def traverse(self, callback):
            self.conductor.traverse(callback)
            differentiable = mi.ParamFlags.Differentiable
            if self.coat.has_textured_eta:
                callback.put("ext_ior", self.coat.textures["int_ior"], differentiable)
            else:
                callback.put("ext_eta", self.coat.opaque_eta, differentiable)

        def class_name(self):
            return self.conductor.class_name()

        def to_string(self):
            return str(self.conductor)

    return ConductorBelow


#: Classes of Mitsuba's dielectrics, and their plugins.
DIELECTRICS = {
    "RoughDielectric": "roughdielectric",
    "SmoothDielectric": "dielectric",
    "ThinDielectric": "thindielectric",
}

#: Mitsuba keeps only the ratio of the indices of a dielectric. Indices of materials have at most
#: this number of decimals. If the ratio times the index of air has more, `ext_ior` was not air.
DECIMALS = 4
#: A ratio is taken for one to vacuum from here: no solid or liquid reflects less.
LEAST_IN_VACUUM = 1.3


class LowestInterface:
    """The surface of a body of glass under coats: a `roughdielectric` or a `dielectric`."""

    DRJIT_STRUCT: ClassVar = {"textures": dict, "index": object}  # for frozen functions

    def __init__(self, bsdf: "mi.BSDF"):
        textures = nested_objects(bsdf)
        names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
        self.textures = {name: textures[name] for name in names if name in textures}  # of widths
        self.index = opaque(index_of(bsdf))  # of the body, relative to air

    @property
    def is_anisotropic(self) -> bool:
        return len(self.textures) == 2

    def alpha(self, si, active):
        """The GGX width, or two `Widths`; a smooth surface has the least one."""
        widths = [texture.eval_1(si, active) for texture in self.textures.values()]
        return Widths(*widths) if self.is_anisotropic else (widths or [mi.Float(MIN_ALPHA)])[0]


def pane(bsdf: "mi.BSDF") -> CoatTextures:
    """The clear, smooth coat that a `thindielectric` is above its lower interface."""
    props = mi.Properties("thindielectric")
    props["alpha"], props["int_ior"] = MIN_ALPHA, index_of(bsdf) * AIR
    return CoatTextures(props)


def index_of(bsdf: "mi.BSDF") -> float:
    """The index of refraction of one of `DIELECTRICS` relative to what lies outside, air."""
    return float(np.ravel(mi.traverse(bsdf)["eta"])[0])


def check_dielectric(bsdf: "mi.BSDF", where: str) -> None:
    """Refuse dielectrics that are no interfaces of the walk."""
    name = DIELECTRICS[bsdf.class_name()]
    tints = [tint for tint in nested_objects(bsdf) if tint.startswith("specular")]
    if tints:
        raise ParameterError(
            f"{where}: the nested '{name}' has a {tints[0]}, which no interface has; "
            "give colour by albedo and sigma_t of the coat"
        )
    if name == "roughdielectric" and GGX not in str(bsdf):
        raise ParameterError(
            f"{where}: the nested 'roughdielectric' has the distribution 'beckmann'; give 'ggx', "
            "which all interfaces of a stack have"
        )
    ratio = index_of(bsdf)
    vacuum = ratio > LEAST_IN_VACUUM and _is_plain(ratio)
    if not (vacuum or abs(ratio - 1) < MIN_INDEX_STEP or _is_plain(ratio * AIR)):
        raise ParameterError(
            f"{where}: the index of the nested '{name}' relative to its ext_ior is {ratio:.5g}, "
            "from which its index in air does not follow; leave out ext_ior, since indices are "
            f"absolute, and give int_ior with at most {DECIMALS} decimals"
        )


def _is_plain(index: float) -> bool:
    """Whether an index was given with at most `DECIMALS` decimals, up to single precision."""
    return abs(index - round(index, DECIMALS)) < 2e-7 * index
