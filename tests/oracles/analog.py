"""Reflected and transmitted light by analog Monte Carlo, independent of the walk's estimator.

Every event is drawn with its physical probability: reflection or refraction at each interface, the
free flight, absorption, scattering. No event is forced, no vertex connects to wo, and photons have
no weights, so that only the physics is common with `urushi.walk.walk`.
"""

import functools
from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core import fresnel, microfacet
from urushi.core.directions import reflect, refract
from urushi.walk import Stack
from urushi.walk.bottoms import Bottom
from urushi.walk.bottoms.dielectric import Reflector
from urushi.walk.medium import sample_hg
from urushi.walk.monte_carlo import average, per_channel


def analog_albedo(
    stack: Stack,
    wi: npt.ArrayLike,
    *,
    walks: int = 1 << 16,
    seed: int = 0,
    transmitted: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Count the photons from `wi` that a stack reflects, or that a slab transmits.

    Arguments and result are those of `urushi.walk.simulate.albedo`, for wi above the horizon.
    Microfacet reflections and refractions that end on the wrong side of the horizon, and those
    masked by Smith's term, are absorbed, as in the model.
    """
    photon = functools.partial(_photon, transmitted)
    return per_channel(
        stack,
        (checks.direction(wi, "wi"),),
        lambda table, row, wi: average(table, row, (wi,), photon, walks=walks, seed=seed),
    )


def _photon(transmitted: bool, layers: Any, bottom: Bottom, wi: Any, rng: Any) -> Any:
    """1 if a photon from wi comes out of the stack on the side that is counted, else 0."""
    index_type = dr.uint32_array_t(type(wi.z))
    alpha, eta = layers.interface(index_type(0))
    w, alive = _cross(-wi, alpha, eta, rng)
    alive &= wi.z > 0
    inside = w.z < 0
    escaped = dr.select(alive & ~inside & (not transmitted), type(wi.z)(1), 0)
    layer, depth = dr.zeros(index_type, dr.width(wi)), dr.zeros(type(wi.z), dr.width(wi))

    def body(alive: Any, w: Any, layer: Any, depth: Any, escaped: Any, rng: Any) -> tuple:
        w, layer, depth, survives, out = _event(layers, bottom, w, layer, depth, rng)
        escaped = dr.select(alive & out & ((w.z < 0) == transmitted), 1, escaped)
        return alive & survives & ~out, w, layer, depth, escaped, rng

    return dr.while_loop(
        state=(alive & inside, w, layer, depth, escaped, rng),
        cond=lambda alive, *_: alive,
        body=body,
        labels=("alive", "w", "layer", "depth", "escaped", "rng"),
        label="analog walk",
    )[4]


def _event(layers: Any, bottom: Bottom, w: Any, layer: Any, depth: Any, rng: Any) -> tuple:
    """Fly to the next event and scatter; returns (w, layer, depth, survives, escaped)."""
    albedo, sigma_t, g = layers.medium(layer)
    down = w.z < 0
    to_boundary = dr.select(down, 1 - depth, depth) / dr.abs(w.z)
    flight = -dr.log(1 - rng.next_float32()) / sigma_t
    collides = flight < to_boundary
    collision = dr.clip(depth - flight * w.z, 0, 1)
    at_bottom = ~collides & down & (layer == layers.count - 1)

    scattered = sample_hg(w, g, rng.next_float32(), rng.next_float32())
    survives = rng.next_float32() < albedo

    u = rng.next_float32(), rng.next_float32(), rng.next_float32()
    if isinstance(bottom, Reflector):  # the lowest interface of a slab
        bounced, kept = _cross(w, bottom.alpha, bottom.eta, rng)
    else:
        bounced, weight, _ = bottom.sample(-w, *u)
        kept = (rng.next_float32() < weight) & (bounced.z > 0)

    index = dr.minimum(dr.select(down, layer + 1, layer), layers.count - 1)
    alpha, eta = layers.interface(index)
    crossed, passes = _cross(w, alpha, dr.select(down, eta, 1 / eta), rng)

    w = dr.select(collides, scattered, dr.select(at_bottom, bounced, crossed))
    survives = dr.select(collides, survives, dr.select(at_bottom, kept, passes))
    rises = w.z > 0
    at_interface = ~collides & ~at_bottom
    escaped = at_interface & (index == 0) & rises & survives
    passed = at_bottom & ~rises & survives
    # Interface i is the bottom of layer i - 1 and the top of layer i.
    layer = dr.select(at_interface, dr.select(rises & ~escaped, index - 1, index), layer)
    depth = dr.select(collides, collision, dr.select(at_bottom | rises, 1, 0))
    return w, layer, depth, survives, escaped | passed


def _cross(w: Any, alpha: Any, eta: Any, rng: Any) -> tuple[Any, Any]:
    """Reflect or refract propagation direction w at an interface; returns (w, survives).

    `eta` is the index of the far side relative to the near side.
    """
    side = dr.select(w.z < 0, type(w.z)(1), -1)
    near = type(w)(-w.x, -w.y, dr.abs(w.z))  # w reversed, in a frame where it comes from above
    m = microfacet.sample_visible_normal(near, alpha, rng.next_float32(), rng.next_float32())
    cos_m = dr.dot(near, m)
    reflectance, cos_t = fresnel.dielectric(cos_m, eta)
    mirrored = rng.next_float32() < reflectance
    out = dr.select(mirrored, reflect(near, m), refract(near, m, cos_t, eta))
    unmasked = rng.next_float32() < microfacet.smith_g1(out, alpha)
    survives = unmasked & (mirrored == (out.z > 0)) & (out.z != 0)
    matched = eta == 1  # no interface
    out, survives = dr.select(matched, -near, out), survives | matched
    return type(w)(out.x, out.y, out.z * side), survives
