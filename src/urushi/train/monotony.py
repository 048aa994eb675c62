"""A penalty for coats that brighten as their medium absorbs more.

Every path through a medium loses by absorption, hence f falls everywhere as sigma_a rises and the
scattering stays. The simulated values say so too, but only of stacks that differ in everything
else as well; the penalty compares a coat with a darker one, and needs no simulated values.
"""

from typing import Any

import jax
import jax.numpy as jnp

from urushi.nets.architecture import Architecture, Params
from urushi.nets.decoder import decode
from urushi.nets.features import coat_features
from urushi.nets.layerer import layer

#: Optical depth that is added by absorption alone: these, row by row and over again.
STEPS = (0.1, 0.3, 1.0)


def rises(
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

    return jnp.maximum(logs(absorbing(coats)) - logs(coats), 0.0)


def absorbing(coats: Any) -> jax.Array:
    """The same coats (B, 5) with more absorption, by one of `STEPS`, and the same scattering."""
    alpha, eta, albedo, sigma_t, g = jnp.moveaxis(coats, -1, 0)
    more = sigma_t + jnp.resize(jnp.asarray(STEPS), sigma_t.shape)
    return jnp.stack([alpha, eta, albedo * sigma_t / more, more, g], axis=-1)
