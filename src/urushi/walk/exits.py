"""Paths out of a stack: one chain of refractions from wo down to every layer, drawn once per walk.

A vertex in layer l connects to wo along a chain of directions u_l, ..., u_0 that rise through the
interfaces l, ..., 0 without scattering. The chain is drawn from outside: u_0 by refracting wo, u_l
by refracting u_{l-1}, with the density a_l. The walk itself, from below, draws u_l with the density
b_l. It can join the chain in any layer, so that several techniques produce the same path. The power
heuristic with exponent 2 (Veach 1997, section 9.2.3) weighs technique k by p_k^2 / sum_j p_j^2; the
sums of squared ratios (p_j / p_k)^2 are kept here.

An interface of index 1 does not exist: the chain goes straight on, with the density and the ratios
of the layer above. Below a topmost interface of index 1 no walk can draw u_0, and the density of
the chain is infinite.
"""

from typing import Any, NamedTuple

import drjit as dr

from urushi.walk import interface
from urushi.walk.interface import flip
from urushi.walk.medium import Medium


def select(mask: Any, a: Any, b: Any) -> Any:
    """Per lane, the tuple `a` where the mask is set and `b`, of the same type, elsewhere."""
    return type(a)(*(dr.select(mask, x, y) for x, y in zip(a, b, strict=True)))


class ExitPath(NamedTuple):
    """The part of the chain above a vertex in layer l."""

    direction: Any  # u_l, the propagation direction in the layer, z > 0
    weight: Any  # product over the chain of BTDF / density, times the cosine of u_l; 0 if it failed
    pdf: Any  # a_l [1/sr]
    ratios: Any  # E_l = 1 + (b_{l-1} / a_{l-1})^2 E_{l-1}: techniques that connect above layer l

    def mis(self, pdf_vertex: Any, ratios_below: Any = 0) -> Any:
        """Weight of the connection at a vertex whose own sampling has the density `pdf_vertex`.

        `ratios_below` is the sum of squared ratios of the techniques that connect at an earlier
        vertex, below this one.
        """
        ratio = pdf_vertex / self.pdf
        return dr.select(self.pdf > 0, 1 / (1 + ratio * ratio * self.ratios + ratios_below), 0)


class ExitPaths:
    """The chain through all layers of a stack, and the scattering of its topmost interface."""

    def __init__(self, layers: Any, wo: Any, rng: Any) -> None:
        self._wo = wo
        self._alpha, self._eta = layers.interface(dr.uint32_array_t(type(wo.z))(0))
        self._of_layer: list[ExitPath] = []
        outside, weight, ratios, index_type = wo, 1, 1, dr.uint32_array_t(type(wo.z))
        for index in range(layers.count):
            # Refract the upward direction `outside` down through one interface, against the light.
            alpha, eta = layers.interface(index_type(index))
            inside, passed = interface.sample_transmission(
                outside, alpha, eta, rng.next_float32(), rng.next_float32()
            )
            # A failed sample gets a vertical direction, so that no cosine is zero.
            inside = dr.select(passed > 0, inside, type(outside)(0, 0, -1))
            _, pdf = interface.transmission(outside, inside, alpha, eta)
            pdf = dr.select(eta == 1, dr.inf, pdf)
            if index > 0:
                above = self._of_layer[-1]
                crossed = Medium.of(*layers.medium(index_type(index - 1)))
                weight = weight * crossed.transmittance(type(wo.z)(1), above.direction.z)
                # b: the density with which a walk that rises from inside continues outside.
                _, ratio = interface.scatter(flip(inside), flip(outside), alpha, 1 / eta)
                ratio /= above.pdf
                ratios = 1 + dr.select(above.pdf > 0, ratio * ratio * above.ratios, 0)
                straight = pdf == dr.inf
                pdf = dr.select(straight, above.pdf, pdf)
                ratios = dr.select(straight, above.ratios, ratios)
            # `passed` is (1 - F) G1 for light that enters. Light that leaves has the same factors
            # divided by eta^2, because a cone of light widens.
            weight = weight * (passed / (eta * eta))
            outside = -inside
            self._of_layer.append(ExitPath(outside, weight, pdf, ratios))

    def at(self, layer: Any) -> ExitPath:
        """The chain above a vertex in `layer`, which may vary per lane."""
        result = self._of_layer[0]
        for index, path in enumerate(self._of_layer[1:], start=1):
            result = select(layer == index, path, result)
        return result

    def through_top(self, w: Any) -> tuple[Any, Any]:
        """BTDF [1/sr] of the topmost interface from propagation direction w to wo, and a_0(w)."""
        f_inward, pdf = interface.transmission(self._wo, -w, self._alpha, self._eta)
        # BTDFs in flux convention differ by eta^2 between the two directions.
        return f_inward / (self._eta * self._eta), pdf

    def reflect_at_top(self, w: Any, u1: Any, u2: Any) -> tuple[Any, Any]:
        """Sample the topmost interface's internal reflection of w; returns (direction, weight)."""
        direction, weight = interface.sample_reflection(
            flip(-w), self._alpha, 1 / self._eta, u1, u2
        )
        return flip(direction), weight
