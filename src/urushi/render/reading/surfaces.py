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
from urushi.nets.lobe import LOBE_NUMBERS, NO_LOBE
from urushi.render import spectrum
from urushi.render.reading.grid import nested_objects

#: The line of a roughconductor's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"


class SurfaceValues(NamedTuple):
    """What a surface is at M points.

    Attributes:
        lobe: float32 (M, C, 6) the lobes of the channels, with widths of at least `MIN_ALPHA`.
        diffuse: float32 (M, C) the reflectance of the Lambertian part.
    """

    lobe: np.ndarray
    diffuse: np.ndarray

    def are_possible(self) -> bool:
        """Whether all of them are numbers of surfaces that conserve energy."""
        factors = np.concatenate([self.lobe[..., :4], self.diffuse[..., None]], axis=-1)
        index = self.lobe[..., 4:]
        return bool(((factors >= 0) & (factors <= 1)).all() and (index >= 0).all())


class KnownSurface(NamedTuple):
    """A `roughconductor` or a `diffuse`, by its textures; those that are missing are one.

    Attributes:
        bare: whether it is a roughconductor: a lobe and no Lambertian part.
        textures: its textures, by the names of the plugin's parameters.
    """

    bare: bool
    textures: dict[str, "mi.Texture"]

    def at(self, uv: np.ndarray) -> SurfaceValues:
        """The surface at points uv (M, 2); textures may give values that no BRDF has."""
        si = dr.zeros(mi.SurfaceInteraction3f, len(uv))
        si.uv = mi.Point2f(np.ascontiguousarray(uv.T, np.float32))
        spectrum.set_bands(si)
        shape = len(uv), spectrum.channel_count()
        lobe = np.empty((*shape, len(LOBE_NUMBERS)), np.float32)
        lobe[...] = NO_LOBE
        if not self.bare:
            return SurfaceValues(lobe, self._channels("reflectance", si, shape))
        alpha = self.textures["alpha"].eval_1(si).numpy()
        lobe[..., 0] = np.maximum(alpha, MIN_ALPHA)[:, None]
        reflectance, eta, k = (
            self._channels(name, si, shape) for name in ("specular_reflectance", "eta", "k")
        )
        # Mitsuba's metal "none" has the index 0 and reflects all light.
        exact = eta > 0
        lobe[..., 1] = lobe[..., 2] = np.where(exact, 0, reflectance)
        lobe[..., 3] = np.where(exact, reflectance, 0)
        lobe[..., 4], lobe[..., 5] = np.where(exact, eta, NO_LOBE[4]), np.where(exact, k, 0)
        return SurfaceValues(lobe, np.zeros(shape, np.float32))

    def _channels(self, name: str, si, shape: tuple[int, int]) -> np.ndarray:
        if name not in self.textures:
            return np.ones(shape, np.float32)
        channels = spectrum.to_channels(self.textures[name].eval(si))
        dr.eval(channels)
        rows = [np.broadcast_to(channel.numpy(), shape[0]) for channel in channels]
        return np.stack(rows, axis=-1)


def known_surface(bsdf: "mi.BSDF") -> KnownSurface | None:
    """The surface of the front side of a BSDF; None: it is known by its values alone."""
    parts = nested_objects(bsdf)
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = parts["brdf_0"]
        parts = nested_objects(bsdf)
    kind = bsdf.class_name()
    if kind == "SmoothDiffuse":
        return KnownSurface(False, parts)
    if kind == "RoughConductor" and "alpha" in parts and GGX in str(bsdf):
        return KnownSurface(True, parts)
    return None
