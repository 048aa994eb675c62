"""Mitsuba BSDFs whose analytic lobes are known from their parameters.

`roughconductor` with the GGX distribution is a lobe and nothing else, `diffuse` has none. Neither
has to be evaluated at pairs of directions, and no lobe has to be fitted to its values. All other
BSDFs are known by their values alone.
"""

from typing import NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.nets.lobe import LOBE_NUMBERS, NO_LOBE

#: The line of a roughconductor's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"


class SurfaceValues(NamedTuple):
    """The parameters of a surface at M points.

    Attributes:
        lobe: float32 (M, C, N) the lobes of the channels, with widths of at least `MIN_ALPHA`;
            N = 7 for surfaces of two widths, otherwise 6.
        diffuse: float32 (M, C) the reflectance of the Lambertian part.
    """

    lobe: np.ndarray
    diffuse: np.ndarray

    def are_possible(self) -> bool:
        """Whether all of them are numbers of surfaces that conserve energy."""
        across = self.lobe[..., 6:]
        factors = [self.lobe[..., :4], across, self.diffuse[..., None]]
        bounded, index = np.concatenate(factors, axis=-1), self.lobe[..., 4:6]
        return bool(((bounded >= 0) & (bounded <= 1)).all() and (index >= 0).all())


class KnownSurface(NamedTuple):
    """A `roughconductor` or a `diffuse`, by its textures. Missing textures are one.

    Attributes:
        bare: whether it is a roughconductor: a lobe and no Lambertian part.
        textures: its textures, by the names of the plugin's parameters.
        coat: the coat whose medium lies above, instead of air, or None.
    """

    bare: bool
    textures: dict[str, "mi.Texture"]
    coat: CoatTextures | None = None

    @property
    def widths(self) -> int:
        """Number of GGX widths of a bare surface: 2 if it may be anisotropic."""
        return 2 if "alpha_u" in self.textures else 1

    def at(self, uv: np.ndarray) -> SurfaceValues:
        """The surface at points uv (M, 2); textures may give values that no BRDF has."""
        shape = len(uv), spectrum.channel_count()
        if self.bare:
            lobe = spectrum.stacked(self.lobes(uv), len(uv))
            return SurfaceValues(lobe, np.zeros(shape, np.float32))
        lobe = np.empty((*shape, len(LOBE_NUMBERS)), np.float32)
        lobe[...] = NO_LOBE
        reflectance = [[value] for value in self._channels("reflectance", spectrum.points(uv))]
        return SurfaceValues(lobe, spectrum.stacked(reflectance, len(uv))[..., 0])

    def lobes(self, uv: np.ndarray) -> list[list]:
        """The lobes of a bare surface at points uv: N Dr.Jit floats for each channel."""
        si = spectrum.points(uv)
        widths = ("alpha",) if self.widths == 1 else ("alpha_u", "alpha_v")
        given = (self.textures[x].eval_1(si) for x in widths)
        # The derivative passes the bound, so that an optimiser can leave it.
        alpha, *across = (dr.replace_grad(dr.maximum(x, MIN_ALPHA), x) for x in given)
        names = ("specular_reflectance", "eta", "k")
        found = []
        above = mi.Float(1) if self.coat is None else self.coat.inside(si)
        columns = [self._channels(x, si) for x in names]
        indices = list(above) if dr.depth_v(above) > 1 else [above] * len(columns[0])
        for reflectance, eta, k, above in zip(*columns, indices, strict=True):
            # Mitsuba's metal "none" has the index 0 and reflects all light.
            exact = eta > 0
            schlick = dr.select(exact, 0, reflectance)
            index = dr.select(exact, eta / above, NO_LOBE[4]), dr.select(exact, k / above, 0)
            factors = schlick, schlick, dr.select(exact, reflectance, 0)
            found.append([alpha, *factors, *index, *across])
        return found

    def _channels(self, name: str, si) -> list:
        """The channels of a texture, as Dr.Jit floats."""
        if name not in self.textures:
            return [mi.Float(1)] * spectrum.channel_count()
        texture = self.textures[name]
        return spectrum.at_bands(si, lambda: spectrum.to_channels(texture.eval(si)))


def known_surface(bsdf: "mi.BSDF") -> KnownSurface | None:
    """The surface of the front side of a BSDF; None: it is known by its values alone."""
    parts = nested_objects(bsdf)
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = parts["brdf_0"]
        parts = nested_objects(bsdf)
    coat = getattr(bsdf, "coat", None)  # of a conductor below a medium
    if coat is not None:
        bsdf = bsdf.conductor
    kind = bsdf.class_name()
    if kind == "SmoothDiffuse":
        return KnownSurface(False, parts)
    if kind == "RoughConductor" and {"alpha", "alpha_u"} & parts.keys() and GGX in str(bsdf):
        return KnownSurface(True, parts, coat)
    return None
