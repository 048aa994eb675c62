"""What the networks are trained to minimise."""

from typing import Any

import jax
import jax.numpy as jnp

from urushi.nets.architecture import Architecture, Params
from urushi.nets.decoder import decode
from urushi.nets.encoder import encode
from urushi.nets.layerer import layer
from urushi.train.examples import Batch

#: [1/sr] Added to the prediction that errors are relative to: differences far below are invisible.
FLOOR = 2e-3

#: Relative errors above this count linearly: a prediction far too dark must not drown the rest.
KNEE = 10.0

#: Every how manieth stack of a batch takes part in the cycle, which decodes all probe pairs.
CYCLE_STRIDE = 16


def relative_error(f_hat: jax.Array, f: Any) -> jax.Array:
    """Mean of ((f_hat - f) / (sg(f_hat) + FLOOR))^2, linear beyond `KNEE`.

    The divisor is a constant to the gradient (sg), so that the gradient is linear in f and the
    minimum lies at the mean of a noisy f: Monte Carlo values of few walks teach without bias
    (Lehtinen et al. 2018), unlike a logarithm or an L1 norm of them.
    """
    error = jnp.abs((f_hat - f) / (jax.lax.stop_gradient(f_hat) + FLOOR))
    return jnp.mean(jnp.where(error < KNEE, error * error, KNEE * (2 * error - KNEE)))


def compose(params: Params, arch: Architecture, probes: Any, coats: tuple[Any, ...]) -> Any:
    """Latent codes (B, 32) of stacks: encode their bottoms, then apply coat after coat.

    Args:
        params, arch: the networks.
        probes: (B, probes) the bottoms' values at the probe pairs.
        coats: as in `Batch`: features of the lowest coats first, (B_k, 17) for the first B_k rows.
    """
    z = encode(params, arch, probes)
    for coat in coats:
        count = coat.shape[0]
        z = jnp.concatenate([layer(params, arch, z[:count], coat), z[count:]])
    return z


def joint_loss(
    params: Params, arch: Architecture, batch: Batch, probe_features: Any
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Loss of encoder, layerer and decoder together, and its terms.

    - fit: decoded values of the composed latents against the simulated ones;
    - cycle: the same after decoding at the probe pairs and encoding again, for some of the stacks,
      so that whatever the networks make can be encoded and coated once more;
    - latent: distance between a latent and its cycled one.
    """
    z = compose(params, arch, batch.probes, batch.coats)
    fit = relative_error(decode(params, arch, z[:, None], batch.features), batch.f)

    chosen = z[::CYCLE_STRIDE]
    again = encode(params, arch, decode(params, arch, chosen[:, None], probe_features))
    f_again = decode(params, arch, again[:, None], batch.features[::CYCLE_STRIDE])
    cycle = relative_error(f_again, batch.f[::CYCLE_STRIDE])
    latent = jnp.mean((again - jax.lax.stop_gradient(chosen)) ** 2)

    loss = fit + 0.2 * cycle + 0.1 * latent
    return loss, {"loss": loss, "fit": fit, "cycle": cycle, "latent": latent}
