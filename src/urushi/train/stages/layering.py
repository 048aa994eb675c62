"""The layering stage: the layerer alone, wider, on quadratic forms about what it makes so far.

Wider hidden layers for a trained network, which at first computes what it did before.
"""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture, layer_sizes
from urushi.nets.mlp import Params
from urushi.train.losses import apply
from urushi.train.order import Order
from urushi.train.stages.quadratic_loss import QuadraticLosses, loss_increase

#: What a stack counts whose uppermost coat lies over a code that was decoded and encoded again,
#: as against the same stack layered coat after coat.
REENTRY = 0.5


class LayeringBatch(NamedTuple):
    """Stacks of all depths, deepest first; B of them, B_k with k coats or more.

    Attributes:
        bottoms, z, slope, curvature: as in `Forms`, of all B.
        coats: for the lowest coat, the next one up, and so on, (B_k, 5) for the first B_k stacks.
        below: (B_2, L) as in `Forms`.
        top: (B_2, 5) their uppermost coats.
    """

    bottoms: np.ndarray
    coats: tuple[np.ndarray, ...]
    below: np.ndarray
    top: np.ndarray
    z: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


class LayeringBatches:
    """Batches by step: every depth's stacks in shuffled epochs.

    Args:
        forms: by number of coats, from one up.
        stacks: how many stacks of each of these depths a step sees.
        seed: of the shuffling.
    """

    def __init__(self, forms: list[QuadraticLosses], stacks: tuple[int, ...], seed: int) -> None:
        self._forms, self._stacks = forms, stacks
        sizes = [len(held.z) for held in forms]
        self._orders = [Order([[n]], n, seed, coats) for coats, n in enumerate(sizes, start=1)]

    def take(self, step: int, steps: int) -> LayeringBatch:
        """The batches of `steps` steps from `step` on, stacked along a first axis."""
        parts: list[QuadraticLosses] = []
        for forms, order, count in reversed(
            list(zip(self._forms, self._orders, self._stacks, strict=True))
        ):
            runs = order.runs(step * count, steps * count)
            rows = np.concatenate([run.items for run in runs])
            parts.append(
                QuadraticLosses(*(x[rows].reshape(steps, count, *x.shape[1:]) for x in forms))
            )
        levels = len(parts)

        def joined(name: str) -> np.ndarray:
            return np.concatenate([getattr(part, name) for part in parts], axis=1)

        several = parts[:-1] or [QuadraticLosses(*(x[:, :0] for x in parts[0]))]
        return LayeringBatch(
            bottoms=joined("bottoms"),
            coats=tuple(
                np.concatenate([part.coats[:, :, -1 - k] for part in parts[: levels - k]], axis=1)
                for k in range(levels)
            ),
            below=np.concatenate([part.below for part in several], axis=1),
            top=np.concatenate([part.coats[:, :, 0] for part in several], axis=1),
            z=joined("z"),
            slope=joined("slope"),
            curvature=joined("curvature"),
        )


def layering_loss(
    params: Params, arch: Architecture, batch: LayeringBatch
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """By how much the stacks' loss exceeds that of the codes before, and its terms.

    - fit: coat after coat over the encoded bottom;
    - reentry: the uppermost coat over all that is below, decoded and encoded again.
    """
    z = apply(params, arch, batch.bottoms, batch.coats)
    fit = loss_increase(z, batch.z, batch.slope, batch.curvature)
    some = slice(len(batch.below))
    again = apply(params, arch, batch.below, (batch.top,))
    reentry = loss_increase(again, batch.z[some], batch.slope[some], batch.curvature[some])
    count = len(fit) + REENTRY * len(reentry)
    loss = (jnp.sum(fit) + REENTRY * jnp.sum(reentry)) / count
    return loss, {"loss": loss, "fit": jnp.mean(fit), "reentry": jnp.sum(reentry) / count}


def widened(
    params: Params, arch: Architecture, part: str, widths: tuple[int, ...], seed: int
) -> dict[str, np.ndarray]:
    """The parameters of one network with hidden layers of other widths (Chen et al. 2016).

    New neurons see all of the layer below by random weights, and weigh nothing in what the old
    ones above see, or the output: values and derivatives by the old parameters stay as they were.

    Args:
        params: all parameters, of the sizes `arch`.
        arch: the sizes before.
        part: the network, one of `architecture.PARTS`.
        widths: of its hidden layers, as many as before and none of them less.
        seed: of the new neurons' weights.

    Raises:
        ParameterError: the widths are not such.
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
