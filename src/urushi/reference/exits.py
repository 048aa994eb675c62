"""Ways out of a stack: one refracted path from wo down to every layer, drawn once per walk.

A vertex in layer l connects to wo along a chain of directions u_l, ..., u_0 that rise through the
interfaces l, ..., 0 without scattering. Drawn from outside, u_l has density a_l given u_{l-1};
drawn by the walk from below it has another, b_l. A chain can therefore be made in several ways, by
leaving the walk at any of its layers, and the power heuristic over all of them (Veach 1997) needs
the sums of squared ratios kept here. The density a is always that of starting outside, at wo.
"""

from typing import Any, NamedTuple

import drjit as dr

from urushi.reference import interface
from urushi.reference.interface import flip


class ExitPath(NamedTuple):
    """The chain as a vertex in one layer sees it."""

    direction: Any  # u_l, the propagation direction in the layer, z > 0
    weight: Any  # product over the chain of BTDF / density, times u_l's cosine; 0 if it failed
    pdf: Any  # a_l [1/sr]
    rivals: Any  # E_l = 1 + (b_{l-1} / a_{l-1})^2 E_{l-1}: ways that leave the walk above layer l

    def mis(self, pdf_vertex: Any, rival: Any = 0) -> Any:
        """The weight of connecting at a vertex that would have drawn u_l with `pdf_vertex`.

        `rival` sums the ways that leave the walk below this vertex.
        """
        ratio = pdf_vertex / self.pdf
        return dr.select(self.pdf > 0, 1 / (1 + ratio * ratio * self.rivals + rival), 0)


class ExitPaths:
    """The chain for all layers of a stack, and the topmost interface as an exit."""

    def __init__(self, layers: Any, wo: Any, rng: Any) -> None:
        self._wo = wo
        self._alpha, self._eta = layers.interface(dr.uint32_array_t(type(wo.z))(0))
        self._of_layer: list[ExitPath] = []
        outside, weight, rivals = wo, 1, 1
        for index in range(layers.count):
            link = self._link(layers, outside, index, rng)
            if index > 0:
                above = self._of_layer[-1]
                _, sigma_t, _ = layers.medium(dr.uint32_array_t(type(wo.z))(index - 1))
                weight = weight * dr.exp(-sigma_t / above.direction.z)
                ratio = self._density_from_below(layers, link.direction, above.direction, index)
                ratio /= above.pdf
                rivals = 1 + dr.select(above.pdf > 0, ratio * ratio * above.rivals, 0)
            weight = weight * link.weight
            self._of_layer.append(ExitPath(link.direction, weight, link.pdf, rivals))
            outside = link.direction

    @staticmethod
    def _link(layers: Any, outside: Any, index: int, rng: Any) -> ExitPath:
        """Refract the upward direction `outside` backwards through one interface."""
        alpha, eta = layers.interface(dr.uint32_array_t(type(outside.z))(index))
        inside, weight = interface.sample_transmission(
            outside, alpha, eta, rng.next_float32(), rng.next_float32()
        )
        # A failed sample keeps a harmless direction, so that nothing divides by its cosine.
        inside = dr.select(weight > 0, inside, type(outside)(0, 0, -1))
        _, pdf = interface.transmission(outside, inside, alpha, eta)
        # `weight` is (1 - F) G1 for light going in; the way out has the same factors and loses
        # eta^2, because a cone of light widens there.
        return ExitPath(-inside, weight / (eta * eta), pdf, 1)

    @staticmethod
    def _density_from_below(layers: Any, inside: Any, outside: Any, index: int) -> Any:
        """b: the density with which a walk rising along `inside` would go on along `outside`."""
        alpha, eta = layers.interface(dr.uint32_array_t(type(inside.z))(index))
        _, pdf = interface.scatter(flip(-inside), flip(outside), alpha, 1 / eta)
        return pdf

    def at(self, layer: Any) -> ExitPath:
        """The chain for a vertex in `layer`, which may vary per lane."""
        result = self._of_layer[0]
        for index, escape in enumerate(self._of_layer[1:], start=1):
            here = layer == index
            result = ExitPath(*(dr.select(here, a, b) for a, b in zip(escape, result, strict=True)))
        return result

    def through_top(self, w: Any) -> tuple[Any, Any]:
        """BTDF [1/sr] of the topmost interface from propagation direction w to wo, and a_0(w)."""
        f_inward, pdf = interface.transmission(self._wo, -w, self._alpha, self._eta)
        # Flux-convention BTDFs of the two directions differ by the squared index.
        return f_inward / (self._eta * self._eta), pdf

    def reflect_at_top(self, w: Any, u1: Any, u2: Any) -> tuple[Any, Any]:
        """Sample the topmost interface's internal reflection of w; returns (direction, weight)."""
        direction, weight = interface.sample_reflection(
            flip(-w), self._alpha, 1 / self._eta, u1, u2
        )
        return flip(direction), weight
