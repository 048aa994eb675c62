"""What the networks are trained to minimise.

A penalty for coats that brighten as their medium absorbs more.

Every path through a medium loses by absorption, hence f falls everywhere as sigma_a rises and the
scattering stays. The simulated values say so too, but only of stacks that differ in everything
else as well; the penalty compares a coat with a darker one, and needs no simulated values.
"""

from typing import Any

import jax
import jax.numpy as jnp

from urushi.nets.architecture import Architecture
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.features import coat_features
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params
from urushi.train.examples import Batch

#: [1/sr] Added to the prediction that errors are relative to: differences far below are invisible.
#: For a dark stack it is less, in proportion to its brightness, down to this share.
FLOOR, DARKEST = 2e-3, 0.05

#: Relative errors above this count linearly: a prediction far too dark must not drown the rest.
KNEE = 10.0

#: A stack whose mean squared relative error is the first counts as it is; the second is added to
#: it, lest a stack that is nearly perfect rule. Both are near the noise of simulated values.
TYPICAL, EASE = 1e-2, 3e-3

#: Errors above this count as this in a stack's weight: what is quite wrong must be drawn back.
WORST = 0.3

#: Codes are held within this, five times the largest that trained networks make: in the first
#: steps five coats one after the other would otherwise let them explode.
LARGEST_CODE = 20.0

#: Consecutive pairs of one mixture, see `geometry.direction_sets.training_pairs`.
_PERIOD = 4

#: Every how manieth stack of a batch takes part in the cycle, which decodes all probe pairs.
CYCLE_STRIDE = 16

#: Every how manieth stack with a coat takes part in the penalty for rising with absorption.
RISE_STRIDE = 12


def divisor(f_hat: jax.Array) -> jax.Array:
    """What errors (S, P) are relative to: the prediction and a floor, constants to the gradient.

    The gradient is linear in f then, and the minimum lies at the mean of a noisy f: Monte Carlo
    values of few walks teach without bias (Lehtinen et al. 2018), unlike a logarithm or an L1 norm
    of them.
    """
    seen = jax.lax.stop_gradient(f_hat)
    brightness = jnp.pi * jnp.mean(jnp.minimum(seen, 1.0), axis=-1, keepdims=True)
    return seen + FLOOR * jnp.clip(brightness, DARKEST, 1.0)


def squared(error: jax.Array) -> tuple[jax.Array, jax.Array]:
    """Squares of relative errors, linear beyond `KNEE`, and half of their slope over the error."""
    size = jnp.abs(error)
    near = jnp.where(size < KNEE, 1.0, KNEE / jnp.maximum(size, KNEE))
    return jnp.where(size < KNEE, error * error, KNEE * (2 * size - KNEE)), near


def relative_errors(f_hat: jax.Array, f: Any) -> jax.Array:
    """Squared relative errors (S, P), linear beyond `KNEE`."""
    return squared((f_hat - f) / divisor(f_hat))[0]


def halves_weight(squares: jax.Array) -> jax.Array:
    """What each of the squared relative errors (S, P) of a stack counts: constants (S, P).

    Every stack's error is divided by about its own root, lest the few hardest ones, narrow lobes
    and nearly black ones, rule what all others learn. A weight that knew the noise of the values
    it weighs would be biased against fireflies; therefore the pairs are halved, and each half is
    weighted by the other's error.
    """
    halves = jax.lax.stop_gradient(squares).reshape(len(squares), -1, 2, _PERIOD)
    others = jnp.minimum(halves.mean(axis=(1, 3))[:, None, ::-1, None], WORST)
    weight = jnp.sqrt(TYPICAL / (EASE + others))
    return jnp.broadcast_to(weight, halves.shape).reshape(squares.shape)


def stack_loss(f_hat: jax.Array, f: Any) -> jax.Array:
    """Mean over stacks of about the root of their mean squared relative error.

    Args:
        f_hat, f: (S, P) predicted and simulated values [1/sr], P a multiple of 8.
    """
    return stacks_mean(relative_errors(f_hat, f))


def stacks_mean(squares: jax.Array, weights: Any = 1.0) -> jax.Array:
    """The same from squared relative errors (S, P), of which each counts `weights` (S, P)."""
    return jnp.mean(weights * halves_weight(squares) * squares)


def compose(params: Params, arch: Architecture, probes: Any, coats: tuple[Any, ...]) -> Any:
    """Latent codes (B, 32) of stacks: encode their bottoms, then apply coat after coat.

    Args:
        params, arch: the networks.
        probes: (B, probes) the bottoms' values at the probe pairs.
        coats: as in `Batch`: the lowest coats first, (B_k, 5) for the first B_k rows.
    """
    return apply(params, arch, _held(encode(params, arch, probes)), coats)


def apply(params: Params, arch: Architecture, z: Any, coats: tuple[Any, ...]) -> Any:
    """Codes of stacks from those of their bottoms (B, 32); the coats as for `compose`."""
    for coat in coats:
        count, features = coat.shape[0], coat_features(*jnp.moveaxis(coat, -1, 0))
        z = jnp.concatenate([_held(layer(params, arch, z[:count], features)), z[count:]])
    return z


@jax.custom_vjp
def _held(z: jax.Array) -> jax.Array:
    """Codes within bounds. Of those outside, the gradient is kept that brings them back."""
    return jnp.clip(z, -LARGEST_CODE, LARGEST_CODE)


def _held_pullback(z: jax.Array, gradient: jax.Array) -> tuple[jax.Array]:
    return (jnp.where((jnp.abs(z) < LARGEST_CODE) | (gradient * z > 0), gradient, 0.0),)


_held.defvjp(lambda z: (_held(z), z), _held_pullback)


def joint_loss(
    params: Params, arch: Architecture, batch: Batch, probe_features: Any
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Loss of encoder, layerer and decoder together, and its terms.

    - fit: decoded values of the composed latents against the simulated ones;
    - cycle: the same after decoding at the probe pairs and encoding again, for some of the stacks,
      so that whatever the networks make can be encoded and coated once more;
    - latent: distance between a latent and its cycled one;
    - rise: by how much ln f rises as a bottom's first coat absorbs more, for some of the stacks.
    """
    bottoms = _held(encode(params, arch, batch.probes))
    z = apply(params, arch, bottoms, batch.coats)
    fit = stack_loss(decode(params, arch, z[:, None], batch.features), batch.f)

    chosen = z[::CYCLE_STRIDE]
    again = _held(encode(params, arch, decode(params, arch, chosen[:, None], probe_features)))
    f_again = decode(params, arch, again[:, None], batch.features[::CYCLE_STRIDE])
    cycle = stack_loss(f_again, batch.f[::CYCLE_STRIDE])
    latent = jnp.mean((again - jax.lax.stop_gradient(chosen)) ** 2)

    rise = jnp.zeros(())
    for lowest in batch.coats[:1]:
        some = slice(0, len(lowest), RISE_STRIDE)
        coats, features = lowest[some], batch.features[some]
        rise = jnp.mean(absorption_penalty(params, arch, bottoms[some], coats, features))

    loss = fit + 0.2 * cycle + 0.1 * latent + 0.5 * rise
    return loss, {"loss": loss, "fit": fit, "cycle": cycle, "latent": latent, "rise": rise}


#: Optical depth that is added by absorption alone: these, row by row and over again.
ABSORPTION_STEPS = (0.1, 0.3, 1.0)


def absorption_penalty(
    params: Params, arch: Architecture, z_bottom: Any, coats: Any, features: Any
) -> jax.Array:
    """Return by how much ln f rises with absorption: (B, P), 0 where it falls.

    Args:
        params, arch: the networks.
        z_bottom: (B, 32) codes of bottoms.
        coats: (B, 5) `data.distribution.COAT_PARAMETERS`.
        features: (B, P, 8) of direction pairs.
    """

    def logs(coats: Any) -> jax.Array:
        z = layer(params, arch, z_bottom, coat_features(*jnp.moveaxis(coats, -1, 0)))
        return jnp.log(decode(params, arch, z[:, None], features))

    return jnp.maximum(logs(with_more_absorption(coats)) - logs(coats), 0.0)


def with_more_absorption(coats: Any) -> jax.Array:
    """The same coats (B, 5) with more absorption, by one of `STEPS`, and the same scattering."""
    alpha, eta, albedo, sigma_t, g = jnp.moveaxis(coats, -1, 0)
    more = sigma_t + jnp.resize(jnp.asarray(ABSORPTION_STEPS), sigma_t.shape)
    return jnp.stack([alpha, eta, albedo * sigma_t / more, more, g], axis=-1)
