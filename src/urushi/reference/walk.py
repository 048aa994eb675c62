"""The position-free random walk through a layered stack (Guo, Hasan & Zhao 2018), in Dr.Jit.

One walk estimates the BRDF f(wi, wo) [1/sr] without the reflection of the topmost interface, which
is analytic. It starts refracted at the top from wi and is unbounded in depth. Two techniques reach
wo, combined by the power heuristic over the direction with which light rises to the top interface:

- A, next-event estimation: a direction is drawn once by refracting *wo* into the stack, and every
  vertex in the first medium or on its lower boundary connects along it;
- B: a direction drawn by a vertex's own scattering reaches the top, where the interface's BTDF
  towards wo is evaluated.

The weight of a direction drawn by B needs the density with which A, starting *outside at wo*, would
have drawn it. And a vertex connects by A before its own sampling, which may fail and end the walk.

The code is generic over Dr.Jit's backends and over scalar or colour throughputs.
"""

from typing import Any, NamedTuple, Protocol

import drjit as dr

from urushi.physics import phase
from urushi.physics.frame import from_cosine
from urushi.reference import channels, interface
from urushi.reference.bottoms import Bottom
from urushi.reference.interface import flip

#: Walks whose throughput falls below this continue with probability throughput / threshold.
ROULETTE_THRESHOLD = 0.25


class Layers(Protocol):
    """The coats of a stack, top to bottom; `index` may vary per lane."""

    count: int

    def interface(self, index: Any) -> tuple[Any, Any]:
        """(alpha, eta) of an interface; eta is relative to the medium above."""

    def medium(self, index: Any) -> tuple[Any, Any, Any]:
        """(albedo, sigma_t, g) of the medium under that interface, floats or colours."""


class Escape(NamedTuple):
    """Technique A's direction: how light rises through the top interface towards wo."""

    direction: Any  # propagation direction inside, z > 0
    weight: Any  # BTDF towards wo / pdf, times the direction's cosine; 0 if sampling failed
    pdf: Any  # density [1/sr] of the direction
    alpha: Any
    eta: Any
    wo: Any

    def btdf(self, w: Any) -> tuple[Any, Any]:
        """BTDF [1/sr] of the top interface from propagation direction w to wo, and A's density."""
        f_inward, pdf = interface.transmission(self.wo, -w, self.alpha, self.eta)
        # Flux-convention BTDFs of the two directions differ by the squared index.
        return f_inward / (self.eta * self.eta), pdf


class Event(NamedTuple):
    """What happens at a vertex: its contribution to wo, and the direction the walk goes on in."""

    contribution: Any
    direction: Any
    throughput: Any
    pdf: Any  # density [1/sr] of the direction


def estimate(
    layers: Layers, bottom: Bottom, wi: Any, wo: Any, rng: Any, color: type, active: Any = True
) -> Any:
    """One walk's estimate of f(wi, wo) [1/sr] of type `color`, top reflection excluded.

    Args:
        layers: the coats.
        bottom: the BRDF under the lowest medium.
        wi, wo: unit directions, Dr.Jit 3-vectors; the estimate is 0 below the horizon.
        rng: a Dr.Jit PCG32 of independent streams per lane.
        color: the Dr.Jit type of throughputs: a float or a colour of the same backend.
        active: mask of lanes that walk.
    """
    scalar, vector = type(wi.z), type(wi)
    index_type = dr.uint32_array_t(scalar)
    hero = channels.pick(color, rng.next_float32())
    alpha, eta = layers.interface(index_type(0))
    w, weight = interface.sample_transmission(
        wi, alpha, eta, rng.next_float32(), rng.next_float32()
    )
    escape = sample_escape(wo, alpha, eta, rng)

    state = {
        "active": active & (weight > 0) & (wi.z > 0) & (wo.z > 0),
        "w": vector(w),  # propagation direction
        "layer": index_type(0),
        "depth": scalar(0),  # in the layer: 0 at its top, 1 at its bottom
        "throughput": color(weight),
        "spectral": color(1),  # all channels' densities relative to the hero's
        "pdf": scalar(0),  # density with which the last vertex drew w
        "result": color(0),
        "rng": rng,
    }

    def body(*values: Any) -> tuple[Any, ...]:
        s = dict(zip(state, values, strict=True))
        advance(s, layers, bottom, escape, hero)
        return tuple(s.values())

    values = dr.while_loop(
        state=tuple(state.values()),
        cond=lambda *values: values[0],
        body=body,
        labels=tuple(state),
        label="layered walk",
    )
    return dict(zip(state, values, strict=True))["result"]


def top_reflection(layers: Layers, wi: Any, wo: Any) -> Any:
    """The part of f(wi, wo) [1/sr] that the topmost interface reflects without letting it in."""
    alpha, eta = layers.interface(dr.uint32_array_t(type(wi.z))(0))
    return interface.reflection(wi, wo, alpha, eta)


def sample_escape(wo: Any, alpha: Any, eta: Any, rng: Any) -> Escape:
    """Refract wo into the stack and turn the direction round."""
    inside, weight = interface.sample_transmission(
        wo, alpha, eta, rng.next_float32(), rng.next_float32()
    )
    # A failed sample keeps a harmless direction, so that nothing divides by its cosine.
    inside = dr.select(weight > 0, inside, type(wo)(0, 0, -1))
    _, pdf = interface.transmission(wo, inside, alpha, eta)
    # `weight` is (1 - F) G1 for light going in; the way out has the same factors and loses eta^2,
    # because a cone of light widens there.
    return Escape(-inside, weight / (eta * eta), pdf, alpha, eta, wo)


def power_heuristic(contribution: Any, pdf_own: Any, pdf_other: Any) -> Any:
    """Weight a contribution of one technique against the other's density of the same direction."""
    ratio = pdf_other / pdf_own
    return dr.select(pdf_own > 0, contribution / (1 + ratio * ratio), 0)


def advance(s: dict[str, Any], layers: Layers, bottom: Bottom, escape: Escape, hero: Any) -> None:
    """One step of the walk: fly to the next vertex, connect to wo, scatter, play roulette."""
    rng, color = s["rng"], type(s["throughput"])
    active = dr.mask_t(s["depth"])(s["active"])
    down = s["w"].z < 0
    medium = layers.medium(s["layer"])
    in_medium = fly(s, medium[1], hero) & active
    visible = transmittance(medium[1], s["depth"], escape)
    u = rng.next_float32(), rng.next_float32(), rng.next_float32()

    at_boundary = active & ~in_medium
    in_first = s["layer"] == 0
    at_top = at_boundary & ~down & in_first
    at_bottom = at_boundary & down & (s["layer"] == layers.count - 1)
    inside = medium_event(s, medium, visible, escape, hero, u)
    top = top_event(s, escape, u)
    low = bottom_event(s, bottom, visible, escape, u)

    seen = color(0)
    seen += dr.select(in_medium & in_first, inside.contribution, 0)
    seen += dr.select(at_bottom & in_first, low.contribution, 0)
    seen += dr.select(at_top, top.contribution, 0)
    chosen = select_event(in_medium, inside, select_event(at_top, top, low))
    if layers.count > 1:
        inner = at_boundary & ~at_top & ~at_bottom
        crossing = inner_event(s, layers, escape, down, u)
        below = dr.select(down, s["layer"] + 1, s["layer"])
        # Both sides of the first medium's lower boundary see the top interface.
        seen += dr.select(inner & (below == 1), crossing.contribution, 0)
        chosen = select_event(inner, crossing, chosen)
        rising = chosen.direction.z > 0
        s["layer"] = dr.select(inner, dr.select(rising, below - 1, below), s["layer"])
        s["depth"] = dr.select(inner, dr.select(rising, 1, 0), s["depth"])

    if hero is not None:
        cos_theta = dr.dot(s["w"], inside.direction)
        ratio = channels.phase_ratio(cos_theta, medium[2], hero)
        s["spectral"] *= dr.select(in_medium, ratio, 1)
    mean = channels.mean(s["spectral"], hero)
    s["result"] += dr.select(active, seen / mean, 0)
    s["w"], s["pdf"] = chosen.direction, chosen.pdf
    survival = dr.minimum(
        channels.strongest(chosen.throughput, hero) / (mean * ROULETTE_THRESHOLD), 1
    )
    s["throughput"] = dr.select(survival > 0, chosen.throughput / survival, 0)
    s["active"] = active & (rng.next_float32() < survival) & (s["w"].z != 0)


def fly(s: dict[str, Any], sigma_t: Any, hero: Any) -> Any:
    """Move along w to the next collision or boundary of the unit layer; true where it collides."""
    to_boundary = dr.select(s["w"].z < 0, 1 - s["depth"], s["depth"]) / dr.abs(s["w"].z)
    flight = -dr.log(1 - s["rng"].next_float32()) / channels.of_hero(sigma_t, hero)
    in_medium = flight < to_boundary
    distance = dr.select(in_medium, flight, to_boundary)
    s["depth"] = dr.clip(s["depth"] - s["w"].z * distance, 0, 1)
    if hero is not None:
        ratio = channels.flight_ratio(sigma_t, distance, in_medium, hero)
        s["throughput"] *= ratio
        s["spectral"] *= ratio
    return in_medium


def transmittance(sigma_t: Any, depth: Any, escape: Escape) -> Any:
    """Beer's law from `depth` to the top of a layer along the escape direction."""
    return dr.exp(-sigma_t * (depth / escape.direction.z))


def select_event(mask: Any, a: Event, b: Event) -> Event:
    """Per lane, how the walk goes on; contributions are summed apart and dropped here."""
    return Event(None, *(dr.select(mask, x, y) for x, y in zip(a[1:], b[1:], strict=True)))


def medium_event(
    s: dict[str, Any], medium: tuple[Any, Any, Any], visible: Any, escape: Escape, hero: Any, u: Any
) -> Event:
    """A collision in a medium: absorb, and scatter by Henyey and Greenstein's phase function."""
    albedo, _, g = medium
    g_hero = channels.of_hero(g, hero)
    throughput = s["throughput"] * albedo
    cos_escape = dr.dot(s["w"], escape.direction)
    connected = throughput * phase.hg(cos_escape, g) * visible
    connected *= escape.weight / escape.direction.z
    contribution = power_heuristic(connected, escape.pdf, phase.hg(cos_escape, g_hero))
    cos_theta = phase.sample_hg_cosine(g_hero, u[1])
    direction = from_cosine(s["w"], cos_theta, 2 * dr.pi * u[2])
    throughput *= channels.phase_ratio(cos_theta, g, hero)
    return Event(contribution, direction, throughput, phase.hg(cos_theta, g_hero))


def top_event(s: dict[str, Any], escape: Escape, u: Any) -> Event:
    """The topmost interface from below: technique B's exit, then forced internal reflection."""
    f, pdf_escape = escape.btdf(s["w"])
    contribution = power_heuristic(s["throughput"] * f, s["pdf"], pdf_escape)
    direction, weight = interface.sample_reflection(
        flip(-s["w"]), escape.alpha, 1 / escape.eta, u[1], u[2]
    )
    # From below, no vertex is connected upwards before the next one: its density is never asked.
    return Event(contribution, flip(direction), s["throughput"] * weight, type(weight)(0))


def bottom_event(s: dict[str, Any], bottom: Bottom, visible: Any, escape: Escape, u: Any) -> Event:
    """Reflection by the bottom BRDF."""
    f, pdf = bottom.f_pdf(-s["w"], escape.direction)
    connected = s["throughput"] * f * visible * escape.weight
    contribution = power_heuristic(connected, escape.pdf, pdf)
    direction, weight, pdf = bottom.sample(-s["w"], *u)
    return Event(contribution, direction, s["throughput"] * weight, pdf)


def inner_event(s: dict[str, Any], layers: Layers, escape: Escape, down: Any, u: Any) -> Event:
    """An interface between two media of the stack, from either side."""
    index = dr.minimum(dr.select(down, s["layer"] + 1, s["layer"]), layers.count - 1)
    alpha, eta = layers.interface(index)
    eta = dr.select(down, eta, 1 / eta)
    incident = dr.select(down, -s["w"], flip(-s["w"]))
    outgoing = dr.select(down, escape.direction, flip(escape.direction))
    f, pdf = interface.scatter(incident, outgoing, alpha, eta)
    _, sigma_first, _ = layers.medium(type(s["layer"])(0))
    connected = s["throughput"] * f * transmittance(sigma_first, 1, escape) * escape.weight
    contribution = power_heuristic(connected, escape.pdf, pdf)
    direction, weight, pdf = interface.sample(incident, alpha, eta, *u)
    direction = dr.select(down, direction, flip(direction))
    return Event(contribution, direction, s["throughput"] * weight, pdf)
