"""The sampling stage: the sampler learns lobes whose density follows f cos_o."""

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from urushi.checks import Widths
from urushi.nets import lobe as lobes
from urushi.nets import proposal
from urushi.nets.architecture import Architecture
from urushi.nets.features import direction_features
from urushi.nets.mlp import Params
from urushi.nets.sampler import mixture as propose
from urushi.train.examples import Depth
from urushi.train.losses import compose, without_lobe
from urushi.train.stages import Stage, Task

#: Largest number of training stacks of each depth whose codes the sampler is trained on.
STACKS = 1 << 15

#: Materials in a step, each with one incoming direction, and outgoing directions for each.
MATERIALS, DIRECTIONS = 96, 64

#: Channels of a material; they share the proposal of their mean code.
CHANNELS = 3

#: Weights and widths of a fixed mixture from which half of the directions are drawn, so that no
#: part of a BRDF is missed.
FIXED = (0.25, 0.25, 0.25, 0.25), (0.015, 0.06, 0.25)


@dataclass(frozen=True)
class Sampling(Stage):
    """The sampler on codes that encoder and layerer make; its batches are step numbers."""

    name: str = field(default="sampling", kw_only=True)
    trains: ClassVar[tuple[str, ...]] = ("sampler",)

    def task(self, params: Params, arch: Architecture, depths: list[Depth], seed: int) -> Task:
        """`sampler_loss` on random materials between the codes of training stacks."""
        targets, key = (dict(params), training_codes(params, arch, depths)), jax.random.key(seed)
        return Task(
            lambda trained, step: sampler_loss(trained, arch, *targets, key, step),
            lambda step, steps: np.arange(step, step + steps, dtype=np.uint32),
        )


def training_codes(params: Params, arch: Architecture, depths: list[Depth]) -> jax.Array:
    """Latent codes (M, L) of training stacks of all depths, at most `STACKS` of each."""
    run = jax.jit(functools.partial(compose, params, arch))
    codes = []
    for examples in (depth.examples() for depth in depths):
        # Parts lie one after the other: a stride takes some of each.
        rows = slice(None, None, -(-len(examples.probes) // STACKS))
        coats = tuple(np.moveaxis(examples.coats[rows], 1, 0)[::-1])
        codes.append(run(examples.lobes[rows], examples.probes[rows], coats))
    return jnp.concatenate(codes)


def sampler_loss(
    trained: Params,
    arch: Architecture,
    params: Params,
    latents: jax.Array,
    key: jax.Array,
    step: jax.Array,
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Divergence and spread of importance sampling by the proposal, for random materials.

    For each material and wi, half of the directions are drawn from the proposal (constant to the
    gradient) and half from a fixed mixture; q is their joint density. Weighted by f cos_o / q they
    estimate the cross entropy of the proposal p to the normalised f cos_o, and the second moment
    of f cos_o / p under p, whose logarithm is ln(1 + cv^2) of one sample.

    params: trained encoder, layerer and decoder. latents: (M, L) codes of layered and bare stacks,
    one channel each. key: of all random numbers.
    """
    picked, angles, own, fixed = jax.random.split(jax.random.fold_in(key, step), 4)
    z = pick_materials(picked, latents, MATERIALS)
    u = jax.random.uniform(angles, (MATERIALS, 2))
    wi = incoming_directions(u, arch.widths)[:, None]
    weights, alphas = propose(trained, arch, jnp.mean(z, axis=1), wi[:, 0])
    weights, alphas = _broadcastable((weights, alphas), 1)
    constant = jax.lax.stop_gradient
    current = constant(weights), _map(constant, alphas)
    defensive = _broadcastable((jnp.array(FIXED[0]), jnp.array(FIXED[1])), 0)

    half = (MATERIALS, DIRECTIONS // 2, 3)
    drawn = (
        proposal.sample_mixture(*mixture, wi, jax.random.uniform(random, half))
        for mixture, random in ((current, own), (defensive, fixed))
    )
    wo = constant(jnp.concatenate(list(drawn), axis=1))
    q = 0.5 * (proposal.mixture_pdf(*current, wi, wo) + proposal.mixture_pdf(*defensive, wi, wo))
    f_cos = mean_f_cos(params, arch, z, wi, wo)
    p = proposal.mixture_pdf(weights, alphas, wi, wo)

    valid = q > 0
    ratio = jnp.where(valid, f_cos / jnp.where(valid, q, 1), 0)
    total = jnp.mean(ratio, axis=1, keepdims=True)
    share = ratio / total  # f cos_o / (q albedo): mean 1
    p = jnp.where(valid, p, 1)
    cross_entropy = jnp.mean(share * jnp.log(jnp.where(valid, q, 1) / p))
    second_moment = jnp.mean(share * share * jnp.where(valid, q, 0) / p, axis=1)
    spread = jnp.mean(jnp.log(second_moment))
    return spread + cross_entropy, {"loss": spread + cross_entropy, "spread": spread}


def pick_materials(key: jax.Array, latents: jax.Array, count: int) -> jax.Array:
    """Codes (count, CHANNELS, L) of random materials, about half of them grey.

    The channels of a real material are similar. The channels of a coloured one are blends of two
    codes, with a share of the second in [0, 1/2).
    """
    first, second, place, grey = jax.random.split(key, 4)
    z0 = latents[jax.random.randint(first, (count, 1), 0, len(latents))]
    z1 = latents[jax.random.randint(second, (count, 1), 0, len(latents))]
    t = 0.5 * jax.random.uniform(place, (count, CHANNELS, 1))
    t = jnp.where(jax.random.uniform(grey, (count, 1, 1)) < 0.5, 0.0, t)
    return z0 + t * (z1 - z0)


def incoming_directions(u: jax.Array, widths: int) -> jax.Array:
    """Directions (N, 3) with theta_i = 88 degrees times u[:, 0].

    They lie in the xz plane. For BRDFs of two widths they have the azimuth 2 pi u[:, 1].
    """
    theta, phi = u[:, 0] * math.radians(88), (2 * math.pi) * u[:, 1]
    if widths == 1:
        phi = jnp.zeros_like(phi)
    sin = jnp.sin(theta)
    return jnp.stack([sin * jnp.cos(phi), sin * jnp.sin(phi), jnp.cos(theta)], axis=-1)


def mean_f_cos(params: Params, arch: Architecture, z: Any, wi: Any, wo: Any) -> jax.Array:
    """Mean f cos_o (N, M) over the channels of z (N, CHANNELS, L), for wi, wo (N, M, 3)."""
    wi = jnp.broadcast_to(wi, wo.shape)
    features = jnp.repeat(direction_features(wi, wo, arch.widths), z.shape[1], axis=0)
    rest = without_lobe(params, arch, z.reshape(-1, z.shape[-1]), features)
    top = lobes.f(z[:, :, None, : arch.lobe], wi[:, None], wo[:, None])
    return jnp.mean(top + rest.reshape(top.shape), axis=1) * wo[..., 2]


def _map(function: Callable[[jax.Array], jax.Array], alphas: Any) -> Any:
    """`function` of an array of widths, or of both arrays of `Widths`."""
    return alphas.map(function) if isinstance(alphas, Widths) else function(alphas)


def _broadcastable(mixture: tuple[Any, Any], axis: int) -> tuple[Any, Any]:
    """Mixtures with axes for materials and directions; the axes from `axis` on are new."""
    added = functools.partial(jnp.expand_dims, axis=tuple(range(axis, 2)))
    weights, alphas = mixture
    return added(weights), _map(added, alphas)
