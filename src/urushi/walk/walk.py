"""The position-free random walk through a layered stack (Guo, Hasan & Zhao 2018), in Dr.Jit.

One walk estimates the BRDF f(wi, wo) [1/sr] without the reflection of the topmost interface, which
is analytic. It starts with the refraction of wi at the top and has no limit of depth. The middle of
a deep lossless medium is a diffuser (`urushi.walk.medium`). Two techniques reach wo. The power
heuristic combines them over the direction in which light rises to the top interface:

- A, next-event estimation: every vertex connects to wo along a path that is drawn once per walk,
  by refracting *wo* down through the interfaces (see `urushi.walk.exits`);
- B: a direction drawn by a vertex's own scattering reaches the top, where the BTDF of the
  interface towards wo is evaluated.

The weight of a direction drawn by B needs the density with which A, starting *outside at wo*,
would have drawn it. A vertex connects by A before its own sampling, which may fail and end the
walk.

The code is generic over Dr.Jit's backends and over scalar or colour throughputs.
"""

import functools
from typing import Any, NamedTuple, Protocol

import drjit as dr

from urushi.core.directions import square_to_cosine_hemisphere
from urushi.walk import interface, spectral_mis
from urushi.walk.bottoms import Bottom
from urushi.walk.exits import ExitPath, ExitPaths, select
from urushi.walk.interface import flip
from urushi.walk.medium import ROULETTE_THRESHOLD, SHEET_DEPTH, Medium, hg_between, sample_hg


class Layers(Protocol):
    """The coats of a stack, top to bottom; `index` may vary per lane."""

    count: int

    def interface(self, index: Any) -> tuple[Any, Any]:
        """(alpha, eta) of an interface; alpha is one GGX width or `Widths`, the same for all.

        eta is relative to the medium above.
        """

    def medium(self, index: Any) -> tuple[Any, Any, Any]:
        """(albedo, sigma_t, g) of the medium under that interface, floats or colours."""


class Place(NamedTuple):
    """The place at which a flight connects to wo: its collision, or the sheet where it ends."""

    depth: Any  # in the layer
    throughput: Any  # at arrival
    spectral: Any  # all channels' densities of the place relative to the hero's
    mixing: Any  # all channels' densities of a collision there, in proportion


class Event(NamedTuple):
    """The result of a vertex: its contribution to wo, and the next segment of the walk."""

    contribution: Any
    direction: Any
    throughput: Any
    pdf: Any  # density [1/sr] of the direction
    ratios: Any  # sum of squared density ratios of the techniques that connect below this vertex


def estimate(
    layers: Layers,
    bottom: Bottom,
    wi: Any,
    wo: Any,
    rng: Any,
    color: type | None = None,
    active: Any = True,
    entry: Bottom | None = None,
) -> Any:
    """One walk's estimate of f(wi, wo) [1/sr], top reflection excluded.

    Args:
        layers: the coats.
        bottom: the BRDF under the lowest medium.
        wi, wo: unit directions, Dr.Jit 3-vectors; the estimate is 0 below the horizon.
        rng: a Dr.Jit PCG32 of independent streams per lane.
        color: the Dr.Jit type of throughputs and of the result: a colour; None: a float.
        active: mask of lanes that walk.
        entry: the transmission of the bottom to wo above from wi below, where walks start with it;
            None: the bottom is opaque.
    """
    scalar, vector = type(wi.z), type(wi)
    color = color or scalar
    index_type = dr.uint32_array_t(scalar)
    hero = spectral_mis.pick(color, rng.next_float32())
    alpha, eta = layers.interface(index_type(0))
    w, weight = interface.sample_transmission(
        wi, alpha, eta, rng.next_float32(), rng.next_float32()
    )
    exits = ExitPaths(layers, wo, rng)

    state = {
        "active": active & (weight > 0) & (wi.z > 0) & (wo.z > 0),
        "w": vector(w),  # propagation direction
        "layer": index_type(0),
        "depth": scalar(0),  # in the layer: 0 at its top, 1 at its bottom
        "throughput": color(weight),
        "spectral": color(1),  # all channels' densities relative to the hero's
        "pdf": scalar(0),  # density with which the last vertex drew w
        "ratios": scalar(0),  # see Event
        "result": color(0),
        "rng": rng,
    }
    if entry is not None:
        below = active & (wi.z < 0) & (wo.z > 0)
        enter(state, layers, entry, exits, wi, below)

    (state,) = dr.while_loop(
        state=(state,),
        cond=lambda s: s["active"],
        body=lambda s: (advance(s, layers, bottom, exits, hero),),
        label="layered walk",
    )
    return state["result"]


def enter(
    s: dict[str, Any], layers: Layers, entry: Bottom, exits: ExitPaths, wi: Any, below: Any
) -> None:
    """Start the walks of the lanes `below` at the bottom: its transmission is their first event."""
    lowest = type(s["layer"])(layers.count - 1)
    path = exits.at(lowest)
    start = {"w": -wi, "throughput": type(s["throughput"])(1)}
    visible = Medium.of(*layers.medium(lowest)).transmittance(type(s["depth"])(1), path.direction.z)
    u = s["rng"].next_float32(), s["rng"].next_float32(), s["rng"].next_float32()
    first = bottom_event(start, entry, visible, path, u)
    s["active"] |= below & (spectral_mis.greatest(first.throughput) > 0)
    s["result"] += dr.select(below, first.contribution, 0)
    changed = {"w": first.direction, "throughput": first.throughput, "pdf": first.pdf}
    for name, value in (changed | {"layer": lowest, "depth": 1}).items():
        s[name] = dr.select(below, value, s[name])


def top_reflection(layers: Layers, wi: Any, wo: Any) -> Any:
    """The part of f(wi, wo) [1/sr] that is reflected by the topmost interface."""
    alpha, eta = layers.interface(dr.uint32_array_t(type(wi.z))(0))
    return interface.reflection(wi, wo, alpha, eta)


def advance(
    s: dict[str, Any], layers: Layers, bottom: Bottom, exits: ExitPaths, hero: Any
) -> dict[str, Any]:
    """One step of the walk: fly to the next vertex, connect to wo, scatter, play roulette."""
    rng, color = s["rng"], type(s["throughput"])
    active = dr.mask_t(s["depth"])(s["active"])
    down = s["w"].z < 0
    here = Medium.of(*layers.medium(s["layer"]))
    path = exits.at(s["layer"])
    place, in_medium = fly(s, here, down, hero)
    visible = here.transmittance(s["depth"], path.direction.z)
    u = rng.next_float32(), rng.next_float32(), rng.next_float32()

    at_sheet = ~in_medium & here.deep & (s["depth"] == SHEET_DEPTH)
    at_boundary = active & ~in_medium & ~at_sheet
    at_top = at_boundary & ~down & (s["layer"] == 0)
    at_bottom = at_boundary & down & (s["layer"] == layers.count - 1)
    inside, ratio = medium_event(s["w"], here, place, at_sheet, path, hero, u)
    top = top_event(s, exits, u)
    low = bottom_event(s, bottom, visible, path, u)
    chosen = select(at_top, top, low)
    if layers.count > 1:
        inner = at_boundary & ~at_top & ~at_bottom
        chosen = select(inner, inner_event(s, layers, exits, down, u), chosen)
        below = dr.select(down, s["layer"] + 1, s["layer"])
        rising = chosen.direction.z > 0
        s["layer"] = dr.select(inner, dr.select(rising, below - 1, below), s["layer"])
        s["depth"] = dr.select(inner, dr.select(rising, 1, 0), s["depth"])

    # The density of a connection ends at its vertex: it excludes the direction drawn there.
    mean = spectral_mis.mean(s["spectral"], hero)
    s["result"] += dr.select(at_boundary, color(chosen.contribution) / mean, 0)
    mean = spectral_mis.mean(place.spectral, hero)
    scatters = in_medium | at_sheet
    connects = scatters | ((here.scatters < 1) & (spectral_mis.greatest(here.sigma_t) > 0))
    s["result"] += dr.select(active & connects, color(inside.contribution) / mean, 0)
    chosen = select(scatters, inside, chosen)
    if hero is not None:
        s["spectral"] *= dr.select(scatters, ratio, 1)
    mean = spectral_mis.mean(s["spectral"], hero)
    s["w"], s["pdf"], s["ratios"] = chosen.direction, chosen.pdf, chosen.ratios
    survival = dr.minimum(spectral_mis.greatest(chosen.throughput) / (mean * ROULETTE_THRESHOLD), 1)
    s["throughput"] = dr.select(survival > 0, chosen.throughput / survival, 0)
    s["active"] = active & (rng.next_float32() < survival) & (s["w"].z != 0)
    return s


def fly(s: dict[str, Any], here: Medium, down: Any, hero: Any) -> tuple[Place, Any]:
    """Move along w to the next vertex; returns the place to connect, and whether w scatters there.

    Only the share `here.scatters` of the collisions scatters. All other flights go on to the end,
    with the mean weight that absorption leaves them. They also connect to wo once, at a place
    drawn for this connection alone. An expected weight in place of a random absorption never
    increases the variance (Jensen's inequality).
    """
    share, hero_of = here.scatters, functools.partial(spectral_mis.of_hero, hero=hero)
    end = here.end(s["depth"], down)
    to_end = (end - s["depth"]) / -s["w"].z
    visible = dr.exp(-here.sigma_t * to_end)
    reaches = 1 - share + share * visible
    u, meets = s["rng"].next_float32(), share * hero_of(1 - visible)
    scatters = u < meets
    connecting, within = spectral_mis.connecting(here.sigma_t, to_end, hero)
    u = dr.select(scatters, u / share, (u - meets) / (1 - meets) * hero_of(within))
    u = dr.minimum(u, 1 - 2**-24)  # rounding gives 1, where densities would be 0
    distance = -dr.log(1 - u) / dr.select(scatters, hero_of(here.sigma_t), hero_of(connecting))
    distance = dr.minimum(distance, to_end)
    if hero is None:
        weight, density, mixing = dr.select(scatters, 1, (1 - share) * within / reaches), 1, 1
    else:
        mixing = here.sigma_t * dr.exp(-here.sigma_t * distance)
        passing = reaches * connecting * dr.exp(-connecting * distance) / within
        density = dr.select(scatters, share * mixing, passing)
        weight = dr.select(scatters, share, 1 - share) * mixing / hero_of(density)
        density = density / hero_of(density)
    place = Place(
        dr.clip(s["depth"] - s["w"].z * distance, 0, 1),
        s["throughput"] * weight,
        s["spectral"] * density,
        s["spectral"] * mixing,
    )
    spectral = s["spectral"] * (reaches / hero_of(reaches))
    ended = Place(end, s["throughput"] * (visible / hero_of(reaches)), spectral, spectral)
    for name in ("depth", "throughput", "spectral"):
        s[name] = dr.select(scatters, getattr(place, name), getattr(ended, name))
    at_end = ~scatters & here.deep  # the end may be a sheet
    return select(at_end, ended, place), scatters


def medium_event(
    w: Any, here: Medium, place: Place, at_sheet: Any, path: ExitPath, hero: Any, u: Any
) -> tuple[Event, Any]:
    """A collision in a medium, absorption and Henyey-Greenstein scattering, or a sheet.

    Returns also each channel's density of the direction relative to the hero's.
    """
    rises = dr.select(w.z < 0, 1 - here.passed, here.passed)  # the share that a sheet sends up

    def density(direction: Any) -> Any:
        share = dr.select(direction.z > 0, rises, 1 - rises)
        diffuse = share * (dr.abs(direction.z) / dr.pi)
        return dr.select(at_sheet, diffuse, hg_between(w, direction, here.g))

    throughput = place.throughput * here.albedo
    towards_exit = density(path.direction)
    connected = throughput * towards_exit * here.transmittance(place.depth, path.direction.z)
    connected *= path.weight / path.direction.z
    contribution = connected * path.mis(spectral_mis.mixture(towards_exit, place.mixing, hero))
    direction = sample_hg(w, spectral_mis.of_hero(here.g, hero), u[1], u[2])
    diffuse = square_to_cosine_hemisphere(type(w), u[1], u[2])
    diffuse = dr.select(u[0] < spectral_mis.of_hero(rises, hero), diffuse, flip(diffuse))
    direction = dr.select(at_sheet, diffuse, direction)
    pdfs = density(direction)
    ratio = spectral_mis.ratio(pdfs, hero)
    pdf = spectral_mis.mixture(pdfs, place.mixing, hero)
    throughput *= ratio / here.scatters
    return Event(contribution, direction, throughput, pdf, type(pdf)(0)), ratio


def top_event(s: dict[str, Any], exits: ExitPaths, u: Any) -> Event:
    """The topmost interface from below: exit by technique B, then forced internal reflection."""
    f, pdf_exit = exits.through_top(s["w"])
    ratio = pdf_exit / s["pdf"]
    mis = dr.select(s["pdf"] > 0, 1 / (1 + ratio * ratio * (1 + s["ratios"])), 0)
    direction, weight = exits.reflect_at_top(s["w"], u[1], u[2])
    # The next vertex is below: no connection uses this density.
    zero = type(weight)(0)
    return Event(s["throughput"] * f * mis, direction, s["throughput"] * weight, zero, zero)


def bottom_event(s: dict[str, Any], bottom: Bottom, visible: Any, path: ExitPath, u: Any) -> Event:
    """Reflection by the bottom BRDF, or transmission by an entry."""
    f, pdf = bottom.f_pdf(-s["w"], path.direction)
    contribution = s["throughput"] * f * visible * path.weight * path.mis(pdf)
    direction, weight, pdf = bottom.sample(-s["w"], *u)
    return Event(contribution, direction, s["throughput"] * weight, pdf, type(pdf)(0))


def inner_event(s: dict[str, Any], layers: Layers, exits: ExitPaths, down: Any, u: Any) -> Event:
    """An interface between two media, from either side. It connects along the chain above it."""
    index = dr.clip(dr.select(down, s["layer"] + 1, s["layer"]), 1, layers.count - 1)
    above = index - 1
    alpha, eta_below = layers.interface(index)
    eta = dr.select(down, eta_below, 1 / eta_below)
    incident = dr.select(down, -s["w"], flip(-s["w"]))

    def ratios_below(outside: Any) -> Any:
        """Squared ratios of connections below, for a walk that goes on upwards along `outside`."""
        _, pdf_exit = interface.transmission(outside, -s["w"], alpha, eta_below)
        ratio = pdf_exit / s["pdf"]
        return dr.select(down | (s["pdf"] <= 0), 0, ratio * ratio * (1 + s["ratios"]))

    path = exits.at(above)
    outgoing = dr.select(down, path.direction, flip(path.direction))
    f, pdf = interface.scatter(incident, outgoing, alpha, eta)
    visible = Medium.of(*layers.medium(above)).transmittance(type(f)(1), path.direction.z)
    connected = s["throughput"] * f * visible * path.weight
    contribution = connected * path.mis(pdf, ratios_below(path.direction))
    direction, weight, pdf = interface.sample(incident, alpha, eta, *u)
    direction = dr.select(down, direction, flip(direction))
    ratios = dr.select(direction.z > 0, ratios_below(direction), 0)
    # Without an interface this is no vertex: the direction is the one that the last vertex drew.
    pdf = dr.select(eta == 1, s["pdf"], pdf)
    ratios = dr.select(eta == 1, s["ratios"], ratios)
    return Event(contribution, direction, s["throughput"] * weight, pdf, ratios)
