"""Vertices and segments of walks through a stack, for `research.bidirectional`.

A vertex keeps the sum of squared density ratios of all techniques that join two walks before it.
The power heuristic (Veach 1997, section 9.2.3) weighs a joint by these sums. `types` are the
Dr.Jit types of floats, of indices and of throughputs; a throughput is a float or a colour.
"""

from typing import Any, NamedTuple

import drjit as dr

from urushi.core import microfacet
from urushi.walk import interface
from urushi.walk.bottoms import Bottom
from urushi.walk.interface import flip
from urushi.walk.medium import hg, sample_hg
from urushi.walk.spectral_mis import greatest
from urushi.walk.walk import Layers


class Vertex(NamedTuple):
    """A collision, or a meeting with an interface."""

    w: Any  # propagation direction of arrival
    layer: Any  # of arrival
    depth: Any  # in the layer, 0 at its top
    in_medium: Any
    throughput: Any  # before scattering, a float or a colour
    pdf: Any  # of w, at the vertex before
    inverse_edge: Any  # 1 / density of the depth
    ratios: Any  # sums of squared ratios up to the vertex before, for each number of levels


class Segment(NamedTuple):
    """A direction that leaves a vertex."""

    w: Any
    layer: Any
    depth: Any
    from_medium: Any
    throughput: Any
    pdf: Any
    pending: Any  # sums of squared ratios without the density of the vertex's depth, see `arrive`


class Scattering:
    """The scattering of all vertices of a stack."""

    def __init__(self, layers: Layers, bottom: Bottom, index_type: Any) -> None:
        self.layers, self.bottom, self.index = layers, bottom, index_type
        self.last = layers.count - 1

    def _places(self, v: Vertex) -> tuple[Any, Any, Any]:
        """Whether a vertex is on the topmost interface, at the bottom, or on an inner interface."""
        down, boundary = v.w.z < 0, ~v.in_medium
        top = boundary & ~down & (v.layer == 0)
        low = boundary & down & (v.layer == self.last)
        return top, low, boundary & ~top & ~low

    def extinction(self, layer: Any) -> tuple[Any, Any]:
        """sigma_t of a layer, and that by which flights are drawn: 0 without scattering.

        Media that only absorb are crossed with the weight of their transmittance.
        """
        albedo, sigma_t, _ = self.layers.medium(layer)
        return sigma_t, dr.select(greatest(albedo) > 0, sigma_t, 0)

    def departure(self, v: Vertex, w: Any) -> tuple[Any, Any]:
        """Layer and depth at which the direction w leaves a vertex."""
        if not self.last:
            return v.layer, v.depth
        _, _, inner = self._places(v)
        below = dr.select(v.w.z < 0, v.layer + 1, v.layer)
        layer = dr.select(inner, dr.select(w.z > 0, below - 1, below), v.layer)
        return layer, dr.select(inner, dr.select(w.z > 0, 1, 0), v.depth)

    def evaluate(self, v: Vertex, w: Any) -> tuple[Any, Any, Any]:
        """Scattering into w, its density, and the density of the reverse, from -w to -v.w."""
        top, low, inner = self._places(v)
        albedo, _, g = self.layers.medium(v.layer)
        p = hg(dr.dot(v.w, w), g)
        f, pdf, reverse = albedo * p / dr.maximum(dr.abs(w.z), 1e-9), p, p
        alpha, eta = self.layers.interface(self.index(0))
        inside, outgoing = flip(-v.w), flip(w)
        lobe, _ = microfacet.reflection_lobe(inside, outgoing, alpha)
        valid = top & (lobe > 0)
        f = dr.select(top, interface.reflection(inside, outgoing, alpha, 1 / eta), f)
        forth = lobe * outgoing.z / microfacet.smith_g1(outgoing, alpha)
        back = lobe * inside.z / microfacet.smith_g1(inside, alpha)
        pdf = dr.select(top, dr.select(valid, forth, 0), pdf)
        reverse = dr.select(top, dr.select(valid, back, 0), reverse)
        f_low, forth = self.bottom.f_pdf(-v.w, w)
        _, back = self.bottom.f_pdf(w, -v.w)
        f, pdf = dr.select(low, f_low, f), dr.select(low, forth, pdf)
        reverse = dr.select(low, back, reverse)
        if self.last:
            f_inner, forth = self._through(v, v.w, w)
            _, back = self._through(v, -w, -v.w)
            f, pdf = dr.select(inner, f_inner, f), dr.select(inner, forth, pdf)
            reverse = dr.select(inner, back, reverse)
        return f, pdf, reverse

    def _inner(self, v: Vertex) -> tuple[Any, Any]:
        index = dr.clip(dr.select(v.w.z < 0, v.layer + 1, v.layer), 1, self.last)
        return self.layers.interface(index)

    def _through(self, v: Vertex, before: Any, after: Any) -> tuple[Any, Any]:
        """BSDF and density of the inner interface at v between two propagation directions."""
        alpha, eta = self._inner(v)
        down = before.z < 0
        return interface.scatter(
            dr.select(down, -before, flip(-before)),
            dr.select(down, after, flip(after)),
            alpha,
            dr.select(down, eta, 1 / eta),
        )

    def sample(self, v: Vertex, rng: Any) -> tuple[Any, Any]:
        """Draw a direction; returns (w, weight)."""
        u = rng.next_float32(), rng.next_float32(), rng.next_float32()
        top, low, inner = self._places(v)
        albedo, _, g = self.layers.medium(v.layer)
        w = sample_hg(v.w, g, u[1], u[2])
        weight = albedo
        alpha, eta = self.layers.interface(self.index(0))
        found, part = interface.sample_reflection(flip(-v.w), alpha, 1 / eta, u[1], u[2])
        w, weight = dr.select(top, flip(found), w), dr.select(top, part, weight)
        found, part, _ = self.bottom.sample(-v.w, *u)
        w, weight = dr.select(low, found, w), dr.select(low, part, weight)
        if self.last:
            alpha, eta = self._inner(v)
            down = v.w.z < 0
            incident = dr.select(down, -v.w, flip(-v.w))
            found, part, _ = interface.sample(incident, alpha, dr.select(down, eta, 1 / eta), *u)
            found = dr.select(down, found, flip(found))
            w, weight = dr.select(inner, found, w), dr.select(inner, part, weight)
        return w, weight


def edge(sigma_t: Any, distance: Any, w: Any, in_medium: Any) -> Any:
    """Density of a depth, or the probability of a boundary, at the end of a flight along w."""
    visible = dr.exp(-sigma_t * distance)
    return visible * dr.select(in_medium, sigma_t / dr.maximum(dr.abs(w.z), 1e-9), 1)


def enter(types: Any, direction: Any, layers: Layers, rng: Any, levels: int) -> Segment:
    """The refraction of a direction outside into the stack."""
    scalar, index, color = types
    alpha, eta = layers.interface(index(0))
    w, weight = interface.sample_transmission(
        direction, alpha, eta, rng.next_float32(), rng.next_float32()
    )
    w = dr.select(weight > 0, w, type(w)(0, 0, -1))
    _, pdf = interface.transmission(direction, w, alpha, eta)
    start = index(0), scalar(0), dr.mask_t(scalar)(False)
    return Segment(w, *start, color(weight), pdf, [scalar(0) for _ in range(levels)])


def arrive(stack: Scattering, s: Segment, rng: Any) -> Vertex:
    """Fly to the next vertex."""
    sigma_t, drawn = stack.extinction(s.layer)
    to_boundary = dr.select(s.w.z < 0, 1 - s.depth, s.depth) / dr.abs(s.w.z)
    flight = -dr.log(1 - rng.next_float32()) / drawn
    in_medium = flight < to_boundary
    distance = dr.select(in_medium, flight, to_boundary)
    boundary = dr.select(s.w.z < 0, type(s.depth)(1), 0)
    depth = dr.select(in_medium, dr.clip(s.depth - s.w.z * distance, 0, 1), boundary)
    back = dr.square(edge(drawn, distance, s.w, s.from_medium))
    ratios = [bounded(back * p) for p in s.pending]
    inverse = 1 / dr.maximum(edge(drawn, distance, s.w, in_medium), 1e-20)
    throughput = s.throughput * dr.exp((drawn - sigma_t) * distance)
    return Vertex(s.w, s.layer, depth, in_medium, throughput, s.pdf, inverse, ratios)


def leave(stack: Scattering, v: Vertex, w: Any, weight: Any, pdf: Any, back: Any) -> Segment:
    """The segment along a direction drawn at v."""
    layer, depth = stack.departure(v, w)
    levels = len(v.ratios)
    return Segment(
        w,
        layer,
        depth,
        v.in_medium,
        v.throughput * weight,
        pdf,
        [pending(v, back, level) for level in range(levels)],
    )


def pending(v: Vertex, back: Any, level: int) -> Any:
    """Sum of squared ratios of techniques whose joint is before v, but for the depth of v."""
    if level == 0:
        return type(v.pdf)(0)
    ratio = dr.select(v.pdf > 0, back / v.pdf, 0)
    return bounded(dr.square(v.inverse_edge) * (1 + dr.square(ratio) * (1 + v.ratios[level - 1])))


def bounded(x: Any) -> Any:
    """Keeps products finite."""
    return dr.minimum(x, 1e15)
