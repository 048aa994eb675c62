"""Training of the sampling proxy on histograms of half vectors (Fan et al. 2022, supplement)."""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
import optax

from fan2022.architecture import PaperArchitecture, init, parameters_of
from fan2022.inference import direction_inputs, evaluate, layer, proxy
from fan2022.networks import PaperNetworks
from fan2022.palette import Palette
from fan2022.published import cosine_proxy
from urushi.nets.mlp import Params

#: Bins on each side of the square around the unit disk of projected half vectors.
BINS = 40

#: Steps and learning rate, which are not published; each step uses all materials.
STEPS, RATE = 500, 1e-3

RULE = optax.adam(RATE)

#: Components of each kind, stacks of one coat, and incoming directions in `fitted_proxy`.
COMPONENTS, STACKS, INCOMING = 16, 64, 12


class Histograms(NamedTuple):
    """Shares (BINS^2,) of the projected half vectors, averaged over incoming directions."""

    latents: jax.Array  # (M, 32) codes of the materials
    shares: jax.Array  # (M, BINS^2) for f cos_o
    cosine: jax.Array  # (BINS^2,) for a cosine lobe


def centres() -> np.ndarray:
    """The projected half vectors (BINS^2, 2) in the middle of the bins."""
    ticks = (np.arange(BINS) + 0.5) / BINS * 2 - 1
    return np.stack(np.meshgrid(ticks, ticks), axis=-1).reshape(-1, 2).astype(np.float32)


def incoming(count: int, seed: int) -> np.ndarray:
    """Incoming directions (count, 3): theta and phi uniform, as in the data."""
    u = np.random.default_rng((seed, 2)).random((2, count))
    theta, phi = 0.5 * np.pi * u[0], 2 * np.pi * u[1]
    sin = np.sin(theta)
    return np.stack([sin * np.cos(phi), sin * np.sin(phi), np.cos(theta)], -1).astype(np.float32)


def histograms(params: Params, latents: np.ndarray, wi: np.ndarray) -> Histograms:
    """Histograms of materials (M, 32) for incoming directions wi (I, 3)."""
    xy = jnp.asarray(centres())
    squared = jnp.sum(xy * xy, axis=-1)
    h = jnp.concatenate([xy, jnp.sqrt(jnp.maximum(1 - squared, 1e-4))[:, None]], axis=-1)

    def weighted(wi: jax.Array) -> tuple[jax.Array, jax.Array]:
        """Outgoing directions, and cos_o times the Jacobian of the projected half vector."""
        dot = h @ wi
        wo = 2 * dot[:, None] * h - wi
        valid = (squared < 1) & (dot > 0) & (wo[:, 2] > 0)
        return wo, jnp.where(valid, wo[:, 2] * 4 * dot / h[:, 2], 0)

    def share(values: jax.Array) -> jax.Array:
        return values / jnp.maximum(jnp.sum(values), 1e-12)

    def of_material(entry: tuple[jax.Array, jax.Array]) -> jax.Array:
        z, wi = entry
        wo, weight = weighted(wi)
        f = evaluate(params, z, direction_inputs(jnp.broadcast_to(wi, wo.shape), wo))
        return share(jnp.maximum(f, 0) * weight)

    @jax.jit
    def all_shares(latents: jax.Array, wi: jax.Array) -> jax.Array:
        def one(z: jax.Array) -> jax.Array:
            rows = jnp.broadcast_to(z, (len(wi), *z.shape))
            return share(jnp.sum(jax.lax.map(of_material, (rows, wi)), axis=0))

        return jax.lax.map(one, latents)

    cosine = share(jnp.sum(jax.vmap(lambda w: share(weighted(w)[1]))(jnp.asarray(wi)), axis=0))
    return Histograms(jnp.asarray(latents), all_shares(jnp.asarray(latents), wi), cosine)


def divergence(params: Params, data: Histograms) -> jax.Array:
    """Mean Kullback-Leibler divergence of the proposals' histograms from the materials'."""
    mixture = proxy(params, data.latents)
    xy = jnp.asarray(centres())
    squared = jnp.sum(xy * xy, axis=-1)
    logits = -squared / (2 * mixture.sigma[:, None] ** 2)
    gaussian = jax.nn.softmax(jnp.where(squared < 1, logits, -jnp.inf), axis=-1)
    share = mixture.share[:, None]
    q = share * gaussian + (1 - share) * data.cosine
    terms = data.shares * (jnp.log(data.shares + 1e-9) - jnp.log(q + 1e-9))
    return jnp.mean(jnp.sum(terms, axis=-1))


def learn(params: Params, data: Histograms) -> tuple[Params, float]:
    """Train the proxy; returns its parameters and the last divergence."""
    trained = jax.tree.map(jnp.asarray, parameters_of(params, "proxy"))

    def step(state: tuple[Any, Any], _: None) -> tuple[tuple[Any, Any], jax.Array]:
        loss, slope = jax.value_and_grad(divergence)(state[0], data)
        update, optimiser = RULE.update(slope, state[1])
        return (optax.apply_updates(state[0], update), optimiser), loss

    @jax.jit
    def run(trained: Params) -> tuple[Any, jax.Array]:
        return jax.lax.scan(step, (trained, RULE.init(trained)), None, length=STEPS)

    (trained, _), losses = run(trained)
    return trained, float(losses[-1])


def fitted_proxy(params: Params, arch: PaperArchitecture) -> tuple[Params, float]:
    """Train a proxy on stacks whose codes the networks predict; returns its divergence too.

    Dielectrics and conductors of Table 2 are projected and layered. The proxy learns from the
    conductors and the stacks, as in `learn`.

    params: of the evaluation and the layering network. arch: how they are projected.
    """
    source = Palette(1, components=COMPONENTS, stacks=STACKS)
    top, below, albedo, sigma_t = source.parts(slice(0, STACKS))
    networks = PaperNetworks(arch, {**params, **cosine_proxy()}, {})
    codes = {}
    for kind in ("dielectric", "conductor"):
        bare = Palette(0, kind, COMPONENTS, STACKS)
        codes[kind] = networks.encode_bare(kind, bare.draw(slice(0, COMPONENTS)).bottom)
    medium = np.float32(albedo), np.float32(sigma_t)
    stacks = layer(params, codes["dielectric"][top], codes["conductor"][below], *medium)
    latents = np.concatenate([codes["conductor"], stacks]).astype(np.float32)
    data = histograms(params, latents, incoming(INCOMING, seed=0))
    return learn(init(seed=0), data)
