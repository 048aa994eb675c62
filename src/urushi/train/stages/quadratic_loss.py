"""Quadratic forms: what the loss of a stack is to codes close to those that the networks make.

All of a stack's simulated values speak through one gradient and one matrix of the size of a code.
A step that trains on them sees every value of its stacks for a hundredth of what decoding a quarter
of them costs.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

from urushi.geometry.probe_pairs import probe_pairs
from urushi.nets.architecture import Architecture
from urushi.nets.decoder import decode
from urushi.nets.derivatives import decode_log
from urushi.nets.encoder import encode
from urushi.nets.features import direction_features
from urushi.nets.mlp import Params
from urushi.train.examples import Examples
from urushi.train.losses import compose, divisor, halves_weight, squared

#: Items that are decoded at once.
_BLOCK = 1024


class QuadraticLosses(NamedTuple):
    """S stacks of N coats, and their loss about the codes z.

    Attributes:
        bottoms: (S, L) codes of the bottoms.
        below: (S, L) codes of all but the uppermost coat, decoded at the probe pairs and encoded
            again, as by users who coat what they have measured; those of the bottoms for N = 1.
        coats: (S, N, 5) `data.distribution.COAT_PARAMETERS`, top to bottom.
        z: (S, L) codes of the stacks.
        slope, curvature: (S, L), (S, L, L) of the loss with respect to the code, at z.
    """

    bottoms: np.ndarray
    below: np.ndarray
    coats: np.ndarray
    z: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


def loss_increase(codes: Any, z: Any, slope: Any, curvature: Any) -> jax.Array:
    """By how much the loss at `codes` (B, L) exceeds that at z (B, L): (B,)."""
    d = codes - z
    return jnp.sum(slope * d, axis=-1) + 0.5 * jnp.einsum("bk,bkl,bl->b", d, curvature, d)


def quadratic_expansion(
    params: Params, arch: Architecture, z: Any, features: Any, f: Any
) -> tuple[jax.Array, jax.Array]:
    """Slope (B, L) and curvature (B, L, L) of `losses.stack_loss`'s summands at codes z (B, L).

    features (B, P, 8), f (B, P) as for `stack_loss`. The curvature is Gauss and Newton's: that of
    f linear in the code. The weights of errors are held as they are.
    """
    log_f, rise = decode_log(params, arch, z[:, None], features)
    f_hat = jnp.exp(log_f)
    by = divisor(f_hat)
    error = (f_hat - f) / by
    squares, near = squared(error)
    weight = 2.0 * halves_weight(squares) * near / f.shape[-1]
    along = (f_hat / by)[..., None] * rise
    slope = jnp.einsum("bp,bpl->bl", weight * error, along)
    return slope, jnp.einsum("bpk,bpl->bkl", weight[..., None] * along, along)


def measure_quadratic_losses(
    params: Params, arch: Architecture, examples: Examples
) -> QuadraticLosses:
    """The forms of all stacks of one depth, from all of their pairs. At least one coat."""
    at_probes = jnp.asarray(direction_features(*probe_pairs(arch.probes)))

    @jax.jit
    def codes(values: Any, coats: tuple[Any, ...]) -> tuple[jax.Array, jax.Array, jax.Array]:
        below = compose(params, arch, values, coats[:-1])
        if len(coats) > 1:
            below = encode(params, arch, decode(params, arch, below[:, None], at_probes))
        return encode(params, arch, values), below, compose(params, arch, values, coats)

    @jax.jit
    def forms(z: Any, features: Any, f: Any, local: Any) -> tuple[jax.Array, jax.Array]:
        slope, curvature = quadratic_expansion(params, arch, z, features, f)
        return (
            jax.ops.segment_sum(slope, local, _BLOCK),
            jax.ops.segment_sum(curvature, local, _BLOCK),
        )

    coats = tuple(np.moveaxis(examples.coats, 1, 0)[::-1])
    stacks, size = len(examples.coats), arch.latent
    made: list[list[np.ndarray]] = [[], [], []]
    for first in range(0, stacks, _BLOCK):
        some = slice(first, first + _BLOCK)
        block = codes(examples.probes[some], tuple(coat[some] for coat in coats))
        for held, part in zip(made, block, strict=True):
            held.append(np.asarray(part))
    bottoms, below, z = map(np.concatenate, made)

    slope = np.zeros((stacks, size), np.float32)
    curvature = np.zeros((stacks, size, size), np.float32)
    items = np.bincount(examples.stack, minlength=stacks).astype(np.float32)
    for first in tqdm(range(0, len(examples.f), _BLOCK), desc="forms", disable=None):
        some = slice(first, first + _BLOCK)
        rows = examples.stack[some]
        sums = forms(z[rows], examples.features[some], examples.f[some], rows - rows[0])
        here = slice(rows[0], rows[-1] + 1)
        for total, part in zip((slope, curvature), sums, strict=True):
            total[here] += np.asarray(part)[: len(total[here])]
    slope /= items[:, None]
    curvature /= items[:, None, None]
    return QuadraticLosses(bottoms, below, examples.coats, z, slope, curvature)
