"""The joint stage: encoder, layerer and decoder learn together on the simulated stacks."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import jax
import jax.numpy as jnp

from urushi.core.error_metrics import FLOOR
from urushi.core.probe_pairs import probe_pairs
from urushi.nets.architecture import FIXED, Architecture
from urushi.nets.features import direction_features
from urushi.nets.layerer import layer
from urushi.nets.mlp import Params
from urushi.train.batches import Batch, batches
from urushi.train.examples import Depth
from urushi.train.losses import (
    apply_coats,
    columns_of,
    encoded,
    pair_weights,
    stack_loss,
    without_lobe,
)
from urushi.train.stages import Stage, Task

#: Stride of the stacks used in the cycle loss, which decodes all probe pairs.
CYCLE_STRIDE = 16

#: Weight of the cycle loss. A larger one harms the fit: where a stack's lobe is a thousand times
#: the rest, the code of the rest is arbitrary.
CYCLE_SHARE = 0.02

#: Stride of the stacks with a coat that are used in the absorption penalty.
ABSORPTION_STRIDE = 12

#: Optical depths of added absorption; the rows of a batch take them one after the other.
ABSORPTION_STEPS = (0.1, 0.3, 1.0)


@dataclass(frozen=True)
class Joint(Stage):
    """Encoder, layerer and decoder together."""

    stacks: tuple[int, ...]  # stacks of 0, 1, 2, ... coats in a step
    energy_share: float = 0.0  # of the `losses.pair_weights`
    name: str = field(default="joint", kw_only=True)
    trains: ClassVar[tuple[str, ...]] = ("decoder", "encoder", "layerer")

    def task(self, params: Params, arch: Architecture, depths: list[Depth], seed: int) -> Task:
        """`joint_loss` on all simulated stacks."""
        pairs = probe_pairs(arch.probes, arch.widths)
        features = jnp.asarray(direction_features(*pairs, arch.widths))
        fixed = {name: params[name] for name in FIXED}

        def loss(trained: Params, batch: Any) -> tuple[jax.Array, dict[str, jax.Array]]:
            return joint_loss({**fixed, **trained}, arch, batch, features, self.energy_share)

        return Task(loss, batches(depths, self.stacks, seed))


def joint_loss(
    params: Params,
    arch: Architecture,
    batch: Batch,
    probe_features: Any,
    energy_share: float = 0.0,
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Loss of encoder, layerer and decoder, and its terms.

    - fit: decoded values of the composed latent codes against the simulated values, pairs with
      `losses.pair_weights`;
    - cycle: the same after decoding at the probe pairs and encoding again, for every
      `CYCLE_STRIDE`th stack, so that the networks' own output can be encoded and coated;
    - rise: `absorption_penalty` of a bottom's lowest coat, for every `ABSORPTION_STRIDE`th stack.
    """
    bottoms = encoded(params, arch, batch.lobes, batch.probes)
    z = apply_coats(params, arch, bottoms, batch.coats)
    f_hat = batch.top + without_lobe(params, arch, z, batch.features)
    weights = pair_weights(f_hat, batch.features, energy_share)
    fit = stack_loss(f_hat, batch.f, weights)

    some = slice(None, None, CYCLE_STRIDE)
    chosen = z[some]
    values = without_lobe(params, arch, chosen, probe_features)
    again = encoded(params, arch, chosen[:, : arch.lobe], values)
    f_again = batch.top[some] + without_lobe(params, arch, again, batch.features[some])
    cycle = stack_loss(f_again, batch.f[some])

    rise = jnp.zeros(())
    for lowest in batch.coats[:1]:
        rows = slice(0, len(lowest), ABSORPTION_STRIDE)
        coats, features = lowest[rows], batch.features[rows]
        rise = jnp.mean(absorption_penalty(params, arch, bottoms[rows], coats, features))

    loss = fit + CYCLE_SHARE * cycle + 0.5 * rise
    return loss, {"loss": loss, "fit": fit, "cycle": cycle, "rise": rise}


def absorption_penalty(
    params: Params, arch: Architecture, z_bottom: Any, coats: Any, features: Any
) -> jax.Array:
    """Increase (B, P) of ln f of the decoder when a coat's medium absorbs more; 0 where f falls.

    Every path through a medium loses energy by absorption, so f falls everywhere as sigma_a
    rises at constant scattering. Simulated stacks differ in all their parameters, so that they
    show this only indirectly; the penalty compares a coat with a darker one and needs no simulated
    values.

    z_bottom: (B, L) codes of bottoms. coats: (B, C) columns `checks.COAT_COLUMNS`. features:
    (B, P, D) of direction pairs.
    """

    def log_f(coats: Any) -> jax.Array:
        z = layer(params, arch, z_bottom, columns_of(coats))
        return jnp.log(without_lobe(params, arch, z, features) + FLOOR)

    return jnp.maximum(log_f(with_more_absorption(coats)) - log_f(coats), 0.0)


def with_more_absorption(coats: Any) -> jax.Array:
    """Coats (B, C) with absorption added, by one of `ABSORPTION_STEPS`, and equal scattering."""
    before = columns_of(coats)
    more = before.sigma_t + jnp.resize(jnp.asarray(ABSORPTION_STEPS), before.sigma_t.shape)
    after = before._replace(albedo=before.albedo * before.sigma_t / more, sigma_t=more)
    return jnp.stack(after.columns(), axis=-1)
