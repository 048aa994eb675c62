"""Directional albedos of rough interfaces (`core.albedos`) as textures."""

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core import albedos, anisotropic_albedos
from urushi.core.namespace import DRJIT
from urushi.mitsuba.latents.tables import interpolated, stored
from urushi.mitsuba.recording import Recorded


class InterfaceAlbedo(Recorded):
    """Directional albedos of a rough dielectric interface, from above.

    Directions are unit vectors above the horizon, or cosines if the interface has one width.

    eta: its index if it is constant, which methods then need not get, `facets.MIRROR` for facets
        that reflect all light; None: any between 1/3 and 3. two_widths: whether its widths are
        `Widths`.
    """

    def __init__(self, eta: float | None, two_widths: bool = False):
        self._constant, self._two = eta, two_widths
        known = (anisotropic_albedos if two_widths else albedos).tables(self._constant)
        self._reflected = self._tables(known.reflected)
        self._reflected_mean = self._tables(known.reflected_mean)
        self._both = self._tables(known.reflected, known.passed)
        self._both_mean = self._tables(known.reflected_mean, known.passed_mean)
        self._both_entered = self._tables(known.reflected_entered, known.passed_entered)

    def reflected(self, w, alpha, eta=None):
        """Share of the light from a direction that is reflected."""
        return self._reflected(self._at(w, alpha, eta))[0]

    def both(self, w, alpha, eta) -> list:
        """Shares that are reflected and transmitted; the rest would meet a second facet."""
        return self._both(self._at(w, alpha, eta))

    def reflected_mean(self, alpha, eta=None):
        """Share of diffuse light that is reflected."""
        return self._reflected_mean(self._at(None, alpha, eta))[0]

    def both_mean(self, alpha, eta, mirrored=None) -> list:
        """Shares of diffuse light that are reflected and transmitted.

        mirrored: share of it that has entered as `albedos.Tables` says.
        """
        at = self._at(None, alpha, eta)
        diffuse = self._both_mean(at)
        if mirrored is None:
            return diffuse
        entered = self._both_entered(at)
        return [dr.lerp(a, b, mirrored) for a, b in zip(diffuse, entered, strict=True)]

    def _tables(self, *values: np.ndarray):
        """Tables as channels, without the axis of the index if it is constant."""
        table = np.stack(values, axis=-1)
        return Interpolated(table if self._constant is None else table[0])

    def _at(self, w, alpha, eta) -> list:
        eta = eta if self._constant is None else self._constant
        cosine = w.z if isinstance(w, mi.Vector3f) else w
        if not self._two:
            return coordinates(cosine, alpha, eta)
        at = anisotropic_albedos.coordinates(w, alpha, DRJIT)
        if w is not None:
            at = [albedos.cosine_coordinate(cosine, eta, DRJIT), *at]
        if self._constant is None:
            at.append(anisotropic_albedos.index_coordinate(eta, DRJIT))
        return at


def coordinates(cosine, alpha, eta) -> list:
    """Coordinates in [0, 1] of a look-up in tables of `albedos`, their last axis first.

    cosine: None in tables without its axis.
    eta: None in tables that do not depend on it; a float in tables of one index, without its axis.
    """
    at = [] if cosine is None else [albedos.cosine_coordinate(cosine, eta, DRJIT)]
    index = []
    if eta is not None and not isinstance(eta, float):
        index = [albedos.index_coordinate(eta, DRJIT)]
    return [*at, albedos.roughness_coordinate(alpha, DRJIT), *index]


class Interpolated:
    """A table of channels, the last axis, as a function of coordinates in [0, 1].

    The coordinate of the last axis but the channels comes first. The table is linear between its
    nodes, which are from 0 to 1 on each axis.
    """

    def __init__(self, table: np.ndarray):
        *self._shape, self._channels = table.shape
        self._table = stored(table, half=False)

    def __call__(self, at: list) -> list:
        """The channels."""
        places = [dr.clip(mi.Float(x), 0, 1) for x in reversed(at)]
        return interpolated(self._table, self._shape, places)[: self._channels]
