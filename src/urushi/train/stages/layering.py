"""The layering stage: the layerer alone, which may be widened, on quadratic losses of its codes.

A quadratic loss is the loss of a stack, expanded to second order about its latent code. A gradient
(L,) and a matrix (L, L) replace all simulated values of a stack. A training step on them costs 1 %
of one that decodes a quarter of the values.
"""

import functools
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from tqdm import tqdm

from urushi.core.error_metrics import huber_loss
from urushi.core.probe_pairs import probe_pairs
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, layer_sizes
from urushi.nets.decoder import decode_log
from urushi.nets.features import direction_features
from urushi.nets.mlp import Params
from urushi.train.batches import shuffled, taken
from urushi.train.examples import Depth, Examples
from urushi.train.losses import (
    KNEE,
    apply_coats,
    compose,
    encoded,
    error_scale,
    pair_weights,
    stack_weights,
    without_lobe,
)
from urushi.train.stages import Stage, Task

#: Items that are decoded at once.
_BLOCK = 1024

#: Loss weight of stacks whose lower part was decoded and encoded again, relative to the same stacks
#: layered coat after coat.
REENTRY = 0.5


@dataclass(frozen=True)
class Layering(Stage):
    """The layerer on the quadratic losses of all stacks."""

    stacks: tuple[int, ...]  # stacks of 1, 2, ... coats in a step
    # Widths of the layerer's hidden layers before this stage; None: as after it.
    widen_from: tuple[int, ...] | None = None
    seed_offset: int = 0  # added to the preset's seed for the order of the stacks
    energy_share: float = 0.0  # of the `losses.pair_weights`
    name: str = field(default="layering", kw_only=True)
    trains: ClassVar[tuple[str, ...]] = ("layerer",)

    def arch_before(self, arch: Architecture) -> Architecture:
        """The sizes with a layerer that is not yet widened."""
        return arch if self.widen_from is None else replace(arch, layerer=self.widen_from)

    def begin(self, params: Params, arch: Architecture, seed: int) -> dict[str, Any]:
        """The layerer, widened if it was narrower before."""
        if self.widen_from is None:
            return super().begin(params, arch, seed)
        return widened(params, self.arch_before(arch), "layerer", arch.layerer, seed)

    def examples(self, depth: Depth) -> Iterator[Examples]:
        """The stacks of one depth to learn from."""
        yield depth.examples()

    def task(self, params: Params, arch: Architecture, depths: list[Depth], seed: int) -> Task:
        """`layering_loss` on quadratic losses, which are measured first."""
        before, losses = self.arch_before(arch), []
        measure = functools.partial(
            measure_quadratic_losses, params, before, energy_share=self.energy_share
        )
        for depth in depths[1:]:
            measured = list(map(measure, self.examples(depth)))  # holds no examples meanwhile
            depth.forget()
            losses.append(QuadraticLosses(*map(np.concatenate, zip(*measured, strict=True))))
        return Task(
            lambda trained, batch: layering_loss(trained, arch, batch),
            layering_batches(losses, self.stacks, seed + self.seed_offset),
        )


@dataclass(frozen=True)
class MirroredLayering(Layering):
    """`Layering` of two GGX widths on every stack and its mirror image at the plane x = y."""

    def examples(self, depth: Depth) -> Iterator[Examples]:
        """The stacks of one depth, then their mirror images."""
        yield from super().examples(depth)
        depth.forget()
        yield depth.mirrored()


class QuadraticLosses(NamedTuple):
    """The losses of S stacks of N coats about their codes z."""

    bottoms: np.ndarray  # (S, L) codes of the bottoms
    # Codes (S, L) of the stacks without their uppermost coat, decoded at the probe pairs and
    # encoded again, as when a measured stack is coated; the bottoms' codes for N = 1.
    below: np.ndarray
    coats: Any  # (S, N, C) columns `checks.COAT_COLUMNS`, top to bottom
    z: np.ndarray  # (S, K) codes of the stacks, without the lobe's numbers
    slope: np.ndarray  # (S, K) of the loss with respect to z
    curvature: np.ndarray  # (S, K, K)


def layering_batches(
    losses: Sequence[QuadraticLosses], stacks: tuple[int, ...], seed: int
) -> Callable[[int, int], QuadraticLosses]:
    """The function of `Task.batches`: every depth's stacks in shuffled epochs.

    A batch has stacks of all depths, deepest first. Its coats are a tuple as in `batches.Batch`:
    for the lowest coat, the next one up, and so on, (B_k, C) for the first B_k stacks.

    losses: by number of coats, from one up. stacks: of each depth in a step.
    """
    orders = [shuffled(len(x.z), seed, coats) for coats, x in enumerate(losses, start=1)]

    def rows(depth: int, items: np.ndarray) -> dict[str, np.ndarray]:
        return {name: x[items] for name, x in losses[depth]._asdict().items()}

    return lambda step, steps: QuadraticLosses(**taken(orders, rows, stacks, step, steps))


def layering_loss(
    params: Params, arch: Architecture, batch: QuadraticLosses
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """Increase of the stacks' loss over the loss of the measured codes, and its terms.

    - fit: coat after coat over the encoded bottom;
    - reentry: the uppermost coat over the decoded and encoded lower part.
    """
    z = apply_coats(params, arch, batch.bottoms, batch.coats)[:, arch.lobe :]
    fit = loss_increase(z, batch.z, batch.slope, batch.curvature)
    deeper = [*map(len, batch.coats[1:]), 0]  # numbers of stacks with two coats or more, ...
    rows = slice(deeper[0])
    tops = [coat[n:] for coat, n in zip(batch.coats[1:], deeper[1:], strict=True)]
    top = jnp.concatenate([*reversed(tops), batch.coats[0][:0]])
    again = apply_coats(params, arch, batch.below[rows], (top,))[:, arch.lobe :]
    reentry = loss_increase(again, batch.z[rows], batch.slope[rows], batch.curvature[rows])
    count = len(fit) + REENTRY * len(reentry)
    loss = (jnp.sum(fit) + REENTRY * jnp.sum(reentry)) / count
    return loss, {"loss": loss, "fit": jnp.mean(fit), "reentry": jnp.sum(reentry) / count}


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
    curvature is the Gauss-Newton approximation, as if f were linear in the code. The weights of the
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
        of_stacks = functools.partial(jax.ops.segment_sum, segment_ids=local, num_segments=_BLOCK)
        return of_stacks(slope), of_stacks(curvature)

    coats = tuple(np.moveaxis(examples.coats, 1, 0)[::-1])
    stacks, size = len(examples.coats), arch.latent - arch.lobe
    blocks = []
    for first in range(0, stacks, _BLOCK):
        rows = slice(first, first + _BLOCK)
        values = examples.lobes[rows], examples.probes[rows]
        blocks.append(list(map(np.asarray, codes(*values, tuple(coat[rows] for coat in coats)))))
    bottoms, below, z = map(np.concatenate, zip(*blocks, strict=True))
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


def widened(
    params: Params, arch: Architecture, part: str, widths: tuple[int, ...], seed: int
) -> dict[str, np.ndarray]:
    """The parameters of one network after its hidden layers are widened (Chen et al. 2016).

    New neurons have random weights to the layer below, and zero weights to the old neurons above
    and to the output. The network's values and its derivatives by the old parameters are unchanged.

    params, arch: all parameters and the sizes before widening. part: the network, one of
    `architecture.PARTS`. widths: the new ones of its hidden layers, as many as before, none
    smaller. seed: of the new neurons' weights.
    """
    before = getattr(arch, part)
    pairs = zip(before, widths, strict=False)
    if len(widths) != len(before) or any(new < old for old, new in pairs):
        raise ParameterError(
            f"the {part} has hidden layers of {before} neurons, which cannot be widened to {widths}"
        )
    rng = np.random.default_rng(seed)
    old = layer_sizes(arch, part)
    new = (old[0], *widths, old[-1])
    wide: dict[str, np.ndarray] = {}
    for index in range(len(new) - 1):
        rows, columns = new[index : index + 2]
        weight = rng.standard_normal((rows, columns)) * np.sqrt(2.0 / rows)
        weight[:, : old[index + 1]] = 0.0
        weight[: old[index], : old[index + 1]] = params[f"{part}.{index}.weight"]
        bias = np.zeros(columns)
        bias[: old[index + 1]] = params[f"{part}.{index}.bias"]
        wide[f"{part}.{index}.weight"] = weight.astype(np.float32)
        wide[f"{part}.{index}.bias"] = bias.astype(np.float32)
    return wide
