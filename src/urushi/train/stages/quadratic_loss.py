"""Quadratic losses: the loss of a stack, expanded to second order about its latent code.

A gradient (L,) and a matrix (L, L) replace all simulated values of a stack. A training step on them
costs 1 % of one that decodes a quarter of the values.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

from urushi.core.error_metrics import huber_loss
from urushi.core.probe_pairs import probe_pairs
from urushi.nets.architecture import Architecture
from urushi.nets.derivatives import decode_log
from urushi.nets.features import direction_features
from urushi.nets.mlp import Params
from urushi.train.examples import Examples
from urushi.train.losses import (
    KNEE,
    compose,
    encoded,
    error_scale,
    pair_weights,
    stack_weights,
    without_lobe,
)

#: Items that are decoded at once.
_BLOCK = 1024


class QuadraticLosses(NamedTuple):
    """The losses of S stacks of N coats about their codes z.

    Attributes:
        bottoms: (S, L) codes of the bottoms.
        below: (S, L) codes of the stacks without their uppermost coat, decoded at the probe pairs
            and encoded again, as when a measured stack is coated; the bottoms' codes for N = 1.
        coats: (S, N, C) columns `checks.COAT_COLUMNS`, top to bottom.
        z: (S, K) codes of the stacks, without the lobe's numbers.
        slope, curvature: (S, K), (S, K, K) of the loss with respect to these numbers, at z.
    """

    bottoms: np.ndarray
    below: np.ndarray
    coats: np.ndarray
    z: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


def loss_increase(codes: Any, z: Any, slope: Any, curvature: Any) -> jax.Array:
    """Increase (B,) of the loss from z (B, L) to `codes` (B, L)."""
    d = codes - z
    return jnp.sum(slope * d, axis=-1) + 0.5 * jnp.einsum("bk,bkl,bl->b", d, curvature, d)


def quadratic_expansion(
    params: Params,
    arch: Architecture,
    z: Any,
    features: Any,
    top: Any,
    f: Any,
    energy_share: float = 0.0,
) -> tuple[jax.Array, jax.Array]:
    """Slope (B, L) and curvature (B, L, L) of the summands of `losses.stack_loss` at z (B, L).

    z without the lobe's numbers; features (B, P, D), top and f (B, P) as in `Examples`. The
    curvature is that of Gauss and Newton, as if f were linear in the code. The weights of the
    errors are constant. energy_share: of the `losses.pair_weights`.
    """
    log_f, log_slope = decode_log(params, arch, z[:, None], features)
    rest = jnp.exp(log_f)
    f_hat = top + rest
    scale = error_scale(f_hat)
    error = (f_hat - f) / scale
    squares, far = huber_loss(error, KNEE)
    of_pairs = pair_weights(f_hat, features, energy_share)
    weight = 2.0 * of_pairs * stack_weights(of_pairs * squares) / (far * f.shape[-1])
    jacobian = (rest / scale)[..., None] * log_slope
    slope = jnp.einsum("bp,bpl->bl", weight * error, jacobian)
    return slope, jnp.einsum("bpk,bpl->bkl", weight[..., None] * jacobian, jacobian)


def measure_quadratic_losses(
    params: Params, arch: Architecture, examples: Examples, energy_share: float = 0.0
) -> QuadraticLosses:
    """The quadratic losses of all stacks of one depth, at least one coat, from all their pairs.

    energy_share: as in `quadratic_expansion`.
    """
    pairs = probe_pairs(arch.probes, arch.widths)
    at_probes = jnp.asarray(direction_features(*pairs, arch.widths))

    @jax.jit
    def codes(
        lobes: Any, values: Any, coats: tuple[Any, ...]
    ) -> tuple[jax.Array, jax.Array, jax.Array]:
        below = compose(params, arch, lobes, values, coats[:-1])
        if len(coats) > 1:
            decoded = without_lobe(params, arch, below, at_probes)
            below = encoded(params, arch, below[:, : arch.lobe], decoded)
        bottoms = encoded(params, arch, lobes, values)
        return bottoms, below, compose(params, arch, lobes, values, coats)

    @jax.jit
    def expansions(
        z: Any, features: Any, top: Any, f: Any, local: Any
    ) -> tuple[jax.Array, jax.Array]:
        slope, curvature = quadratic_expansion(params, arch, z, features, top, f, energy_share)
        return (
            jax.ops.segment_sum(slope, local, _BLOCK),
            jax.ops.segment_sum(curvature, local, _BLOCK),
        )

    coats = tuple(np.moveaxis(examples.coats, 1, 0)[::-1])
    stacks, size = len(examples.coats), arch.latent - arch.lobe
    blocks: list[list[np.ndarray]] = [[], [], []]
    for first in range(0, stacks, _BLOCK):
        rows = slice(first, first + _BLOCK)
        values = examples.lobes[rows], examples.probes[rows]
        block = codes(*values, tuple(coat[rows] for coat in coats))
        for column, part in zip(blocks, block, strict=True):
            column.append(np.asarray(part))
    bottoms, below, z = map(np.concatenate, blocks)
    z = z[:, arch.lobe :]

    slope = np.zeros((stacks, size), np.float32)
    curvature = np.zeros((stacks, size, size), np.float32)
    counts = np.bincount(examples.stack, minlength=stacks).astype(np.float32)
    for first in tqdm(range(0, len(examples.f), _BLOCK), desc="quadratic losses", disable=None):
        items = slice(first, first + _BLOCK)
        stack = examples.stack[items]
        of_items = examples.features[items], examples.top[items], examples.f[items]
        sums = expansions(z[stack], *of_items, stack - stack[0])
        rows = slice(stack[0], stack[-1] + 1)
        for total, part in zip((slope, curvature), sums, strict=True):
            total[rows] += np.asarray(part)[: len(total[rows])]
    slope /= counts[:, None]
    curvature /= counts[:, None, None]
    return QuadraticLosses(bottoms, below, examples.coats, z, slope, curvature)
