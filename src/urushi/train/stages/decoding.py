"""The decoding stage: the decoder alone, on pairs that may be weighted by their scatter."""

from dataclasses import replace
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.mlp import Params
from urushi.train.examples import Batch
from urushi.train.losses import compose, relative_errors, stack_loss, stacks_mean

#: The network of the scatter has the decoder's form, and these hidden layers.
WIDTHS = (16, 16)

#: Logarithm of the mean squared relative error that it starts from, about that of all pairs.
_START = -5.0

#: Squared relative errors above this count as this to the scatter, and their likelihoods as that:
#: a single firefly shall not make a whole region count nothing.
_LARGEST, _UNLIKELY = 1.0, 50.0

#: Mean squared relative errors below this make a pair count no more: 0.3 % is good enough.
_LEAST = 1e-5

#: What the scatter's likelihood counts beside the decoder's loss, whose gradient it shares a limit
#: with and nothing else.
_SHARE = 0.02


def fresh_scatter(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Parameters "scatter.*" of a network that knows nothing yet."""
    drawn = init(replace(arch, decoder=WIDTHS), seed)
    params = {_renamed(k, "decoder", "scatter"): drawn[k] for k in drawn if k.startswith("decoder")}
    params[f"scatter.{len(WIDTHS)}.bias"] += np.float32(_START)
    return params


def scatter(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Mean squared relative error (S, P) to be expected at codes z (S, L), features (S, P, 8).

    It is what a simulated value's noise and the decoder's own error make together, by code and
    directions only: whatever it weighs is not biased by the noise of the value at hand. The gain,
    which relative errors do not depend on, is left out.
    """
    own = (name for name in params if name.startswith("scatter"))
    alike = {_renamed(name, "scatter", "decoder"): params[name] for name in own}
    z = jnp.concatenate([jnp.zeros_like(z[..., :1]), z[..., 1:]], axis=-1)
    return decode(alike, replace(arch, decoder=WIDTHS), z[:, None], features)


def unlikelihood(scatter: Any, squares: Any) -> jax.Array:
    """Least, on average over `squares` (S, P), where `scatter` (S, P) is their mean.

    Of a Gaussian's logarithm, whose variance is predicted (Nix & Weigend 1994).
    """
    ratio = jnp.minimum(squares, _LARGEST) / scatter
    return jnp.mean(jnp.minimum(ratio, _UNLIKELY) + jnp.log(scatter))


def pair_weights(scatter: Any) -> jax.Array:
    """What each pair of a stack (S, P) counts: the root of its precision, 1 on average."""
    weights = 1.0 / jnp.sqrt(scatter + _LEAST)
    return weights / jnp.mean(weights, axis=-1, keepdims=True)


def plain_loss(
    trained: Params, params: Params, arch: Architecture, batch: Batch
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """`losses.stack_loss` on the codes that the others make, all pairs alike, and its terms.

    Args:
        trained: "decoder.*".
        params: all others.
    """
    z = compose(params, arch, batch.probes, batch.coats)
    fit = stack_loss(decode(trained, arch, z[:, None], batch.features), batch.f)
    return fit, {"loss": fit}


def weighted_loss(
    trained: Params, params: Params, arch: Architecture, batch: Batch
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Loss of decoder and scatter on the codes that the others make, and its terms.

    - fit: as `losses.stack_loss`, but pairs that are hard, or whose values are noisy, count less;
    - scatter: the unlikelihood of the errors.

    Args:
        trained: "decoder.*" and "scatter.*".
        params: all others.
    """
    z = compose(params, arch, batch.probes, batch.coats)
    squares = relative_errors(decode(trained, arch, z[:, None], batch.features), batch.f)
    expected = scatter(trained, arch, z, batch.features)
    weights = jax.lax.stop_gradient(pair_weights(expected))
    fit = stacks_mean(squares, weights)
    unlikely = unlikelihood(expected, jax.lax.stop_gradient(squares))
    loss = fit + _SHARE * unlikely
    return loss, {"loss": loss, "fit": fit, "scatter": unlikely}


def _renamed(name: str, old: str, new: str) -> str:
    return new + name.removeprefix(old)
