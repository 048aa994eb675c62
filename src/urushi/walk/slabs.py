"""Slabs: layers between two half-spaces, which scatter light from either side to both.

A slab is a stack over a dielectric interface that transmits. It is turned upside down where wo is
below it, so that light always leaves upwards. Light that enters from above is then reflected, as by
any stack. Light that enters from below meets the lowest interface first (`Entry`). The walk is the
same from there on.

f is that of importance: its integral over the cosine of wo is the share of power. Of radiance it is
1 / eta^2 times as large, eta being the index on wo's side relative to that on wi's, as in Mitsuba.
If all interfaces have the index 1, unscattered light goes straight on. This delta, of the share
exp(-sigma_t / cos), is no part of f.
"""

from typing import Any

import drjit as dr

from urushi.core.microfacet import of_widths
from urushi.core.namespace import DRJIT, Namespace
from urushi.walk import interface, walk
from urushi.walk.bottoms.dielectric import Reflector
from urushi.walk.interface import flip


class Entry:
    """The lowest interface as light from below passes it: a `Bottom` for wi below the horizon."""

    def __init__(self, alpha: Any, eta: Any) -> None:
        """eta: of the medium below relative to that above."""
        self._alpha, self._eta = alpha, 1 / eta

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        return interface.transmission(flip(wi), flip(wo), self._alpha, self._eta)

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        wo, weight = interface.sample_transmission(flip(wi), self._alpha, self._eta, u1, u2)
        _, pdf = interface.transmission(flip(wi), wo, self._alpha, self._eta)
        return flip(wo), weight, dr.select(self._eta == 1, dr.inf, pdf)


class Slab:
    """The walk's `Layers`: coats over an interface that transmits, upside down in some lanes.

    Attributes:
        bottom, entry: the lowest interface, for light from above and from below.
        index: of the medium below the slab relative to that above.
    """

    def __init__(self, coats: walk.Layers, lowest: Reflector, turned: Any) -> None:
        self.count = coats.count
        self._coats, self._lowest, self._turned = coats, lowest, turned
        last = self.interface(dr.uint32_array_t(turned)(self.count))
        self.bottom, self.entry = Reflector(*last), Entry(*last)
        self.index = last[1]
        for index in range(self.count):
            self.index = self.index * self.interface(dr.uint32_array_t(turned)(index))[1]

    def interface(self, index: Any) -> tuple[Any, Any]:
        index = dr.select(self._turned, self.count - index, index)
        alpha, eta = self._coats.interface(dr.minimum(index, self.count - 1))
        lowest = index == self.count
        eta = dr.select(lowest, self._lowest.eta, eta)
        alpha = of_widths(lambda a, b: dr.select(lowest, a, b), self._lowest.alpha, alpha)
        return alpha, dr.select(self._turned, 1 / eta, eta)

    def medium(self, index: Any) -> tuple[Any, Any, Any]:
        return self._coats.medium(dr.select(self._turned, self.count - 1 - index, index))


def straight(wi: Any, eta: Any, xp: Namespace = DRJIT) -> Any:
    """A direction that a mirror would reflect where straight light from wi goes, mirrored back.

    wi: above the horizon. eta: index on the far side of the slab relative to that on wi's.
    """
    x, y = wi.x / eta, wi.y / eta
    # Totally reflected light has no direction; what scatters inside leaves anywhere.
    return xp.normalized(type(wi)(x, y, xp.sqrt(xp.maximum(1 - x * x - y * y, 1e-3))))


def estimate(
    coats: walk.Layers,
    lowest: Reflector,
    wi: Any,
    wo: Any,
    rng: Any,
    color: type | None = None,
    active: Any = True,
) -> Any:
    """One walk's estimate of f(wi, wo) [1/sr] of a slab, of importance.

    lowest: the interface under the coats. wi, wo: on either side. The other arguments are those of
    `urushi.walk.walk.estimate`.
    """
    turned = wo.z < 0
    wi, wo = (dr.select(turned, flip(w), w) for w in (wi, wo))
    slab = Slab(coats, lowest, turned)
    f = walk.estimate(slab, slab.bottom, wi, wo, rng, color, active, slab.entry)
    return f + walk.top_reflection(slab, wi, wo)
