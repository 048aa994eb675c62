"""The decoding stage: the decoder alone, with pairs that are weighted by their scatter.

The scatter of a pair is its expected squared relative error: noise of the simulated value and error
of the decoder together. A small network predicts it from code and directions; it is trained beside
the decoder and discarded after the stage.
"""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import jax
import jax.numpy as jnp
import numpy as np

from urushi.nets.architecture import Architecture, init
from urushi.nets.decoder import decode
from urushi.nets.mlp import Params
from urushi.train.batches import Batch, batches
from urushi.train.examples import Depth
from urushi.train.losses import (
    compose,
    mean_loss,
    pair_weights,
    squared_errors,
    without_lobe,
)
from urushi.train.stages import Stage, Task

#: Widths of the hidden layers of the scatter's network, which has the form of the decoder.
WIDTHS = (16, 16)

#: Logarithm of the scatter at the start, about its mean over all pairs.
_START = -5.0

#: Upper bounds of a squared relative error and of its ratio to the scatter, in the likelihood: a
#: single firefly must not remove the weight of a whole region.
_LARGEST, _LARGEST_RATIO = 1.0, 50.0

#: Scatter below which the weight of a pair no longer increases: an error of 0.3 % is good enough.
_LEAST = 1e-5

#: Weight of the scatter's likelihood in the loss. The two networks share the bound of the
#: gradient's norm and nothing else.
_SHARE = 0.02


@dataclass(frozen=True)
class Decoding(Stage):
    """The decoder on the codes that the other networks compose."""

    stacks: tuple[int, ...]  # stacks of 0, 1, 2, ... coats in a step
    energy_share: float = 0.0  # of the `losses.pair_weights`
    name: str = field(default="decoding", kw_only=True)
    trains: ClassVar[tuple[str, ...]] = ("decoder",)

    def begin(self, params: Params, arch: Architecture, seed: int) -> dict[str, Any]:
        """The decoder, and a fresh network of the scatter."""
        return super().begin(params, arch, seed) | fresh_scatter(arch, seed)

    def task(self, params: Params, arch: Architecture, depths: list[Depth], seed: int) -> Task:
        """`weighted_loss` on all simulated stacks."""
        return Task(
            lambda trained, batch: weighted_loss(trained, params, arch, batch, self.energy_share),
            batches(depths, self.stacks, seed + 1),
        )


def fresh_scatter(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Untrained parameters "scatter.*"."""
    drawn = init(replace(arch, decoder=WIDTHS), seed)
    params = _renamed(drawn, "decoder", "scatter")
    params[f"scatter.{len(WIDTHS)}.bias"] += np.float32(_START)
    return params


def _renamed(params: Params, old: str, new: str) -> dict[str, Any]:
    """The parameters of one network, under the name of another."""
    return {new + k.removeprefix(old): x for k, x in params.items() if k.startswith(old)}


def scatter(params: Params, arch: Architecture, z: Any, features: Any) -> Any:
    """Expected squared relative error (S, P) at codes z (S, L) and features (S, P, D).

    It depends on code and directions only, so that weighting by it is not biased by the noise of
    the value that is weighted. The gain, the first number of a code, does not enter, because
    relative errors do not depend on it.
    """
    rest = z[:, None, arch.lobe :]
    rest = jnp.concatenate([jnp.zeros_like(rest[..., :1]), rest[..., 1:]], axis=-1)
    as_decoder = _renamed(params, "scatter", "decoder")
    return decode(as_decoder, replace(arch, decoder=WIDTHS), rest, features)


def negative_log_likelihood(scatter: Any, squares: Any) -> jax.Array:
    """Mean over `squares` (S, P), least where `scatter` (S, P) is their mean.

    Of a Gaussian whose variance is predicted (Nix and Weigend 1994), up to factor and constant.
    """
    ratio = jnp.minimum(squares, _LARGEST) / scatter
    return jnp.mean(jnp.minimum(ratio, _LARGEST_RATIO) + jnp.log(scatter))


def scatter_weights(scatter: Any) -> jax.Array:
    """Weights (S, P) of a stack's pairs: the root of their precision, 1 on average."""
    weights = 1.0 / jnp.sqrt(scatter + _LEAST)
    return weights / jnp.mean(weights, axis=-1, keepdims=True)


def weighted_loss(
    trained: Params,
    params: Params,
    arch: Architecture,
    batch: Batch,
    energy_share: float = 0.0,
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Loss of decoder and scatter on composed codes, and its terms.

    - fit: as `losses.stack_loss`, with less weight for pairs that are hard or noisy;
    - scatter: the negative log-likelihood of the errors.

    trained: "decoder.*" and "scatter.*". params: all; encoder and layerer compose the codes.
    energy_share: of the `losses.pair_weights`.
    """
    z = compose(params, arch, batch.lobes, batch.probes, batch.coats)
    f_hat = batch.top + without_lobe(trained, arch, z, batch.features)
    squares = squared_errors(f_hat, batch.f)
    expected = scatter(trained, arch, z, batch.features)
    weights = jax.lax.stop_gradient(scatter_weights(expected))
    energies = pair_weights(f_hat, batch.features, energy_share)
    fit = mean_loss(energies * squares, weights)
    unlikely = negative_log_likelihood(expected, jax.lax.stop_gradient(squares))
    loss = fit + _SHARE * unlikely
    return loss, {"loss": loss, "fit": fit, "scatter": unlikely}
